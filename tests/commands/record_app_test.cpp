// SPDX-License-Identifier: MIT
// `airclay cameras` and `airclay record` as a user runs them, on files and a network camera.
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "capture/takes/take.h"
#include "capture/takes/take_writer.h"
#include "engine/core/error.h"
#include "tests/support/mjpeg_server.h"
#include "tests/support/program.h"
#include "tests/support/scene.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Strings = std::vector<std::string>;

constexpr int kBackground = 5;

void expectRefused(const Strings& arguments, int status, const std::string& expected) {
  const RunResult result = runAirclay(arguments);
  EXPECT_EQ(result.status, status) << result.output;
  ASSERT_EQ(result.errorLines().size(), 1u) << result.errors;
  EXPECT_NE(result.errors.find(expected), std::string::npos) << result.errors;
}

json jsonOf(const Strings& arguments) {
  const RunResult result = runAirclay(arguments);
  EXPECT_EQ(result.status, 0) << result.errors;
  return json::parse(result.output);
}

/// Lossless videos of three cameras; frame k of camera c has a unique grey level.
struct Videos {
  TemporaryFolder folder;
  Rig rig;
  static constexpr int kFrames = 45;

  explicit Videos(int width = 64, int height = 48) : rig(ringRig(3, width, height)) {
    TakeWriter writer(folder / "source", rig, {.rate_hz = 30});
    for (int k = 0; k < kFrames; ++k) {
      RecordedSet set;
      for (std::size_t c = 0; c < 3; ++c)
        set.bytes.emplace_back(std::size_t(3) * std::size_t(width) * std::size_t(height), grey(c, k));
      writer.write(std::move(set));
    }
    writer.finish();
  }
  static std::uint8_t grey(std::size_t camera, int frame) { return std::uint8_t(60 * camera + frame + 1); }
  std::string file(const std::string& name) const { return (folder / ("source/" + name + ".mkv")).string(); }
  std::string out() const { return (folder / "take").string(); }
  Strings record(const Strings& more) const {
    Strings arguments = {"record", "--out", out()};
    for (const Camera& camera : rig.cameras) {
      arguments.push_back("--camera");
      arguments.push_back(camera.name + "=" + file(camera.name));
    }
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  Strings withRig(const Strings& more) const {
    Strings arguments = record(more);
    arguments.insert(arguments.end(), {"--rig", (folder / "source/rig.toml").string()});
    return arguments;
  }
};

/// The take's frames of each camera are the source's frames from `first` on.
void expectFrames(Take& take, const Rig& rig, int first) {
  std::vector<std::vector<std::uint8_t>> images;
  for (const Camera& camera : rig.cameras)
    images.emplace_back(std::size_t(3) * std::size_t(camera.width) * std::size_t(camera.height));
  const std::vector<std::span<std::uint8_t>> buffers(images.begin(), images.end());
  for (int k = 0; k < take.frameCount(); ++k) {
    ASSERT_TRUE(take.readImages(k, buffers));
    for (std::size_t c = 0; c < images.size(); ++c)
      EXPECT_EQ(int(images[c][100]), int(Videos::grey(c, first + k))) << "frame " << k << ", camera " << c;
  }
}

TEST(RecordApp, RecordsEveryFrameWithItsTime) {
  const Videos videos;
  const json figures = jsonOf(videos.withRig({"--background", std::to_string(kBackground), "--json"}));
  EXPECT_EQ(figures["sets"], Videos::kFrames - kBackground);
  EXPECT_EQ(figures["background_sets"], kBackground);
  EXPECT_EQ(figures["incomplete"], 0);
  EXPECT_NEAR(figures["hz"], 30, 0.01);
  EXPECT_NEAR(figures["skew_ms"]["worst"], 0, 0.001);
  for (const json& camera : figures["cameras"]) EXPECT_EQ(camera["drops"], 0);

  Take take(videos.out());
  ASSERT_EQ(take.frameCount(), Videos::kFrames - kBackground);
  EXPECT_TRUE(take.hasBackground());
  expectFrames(take, videos.rig, kBackground);
  for (int k = 0; k < take.frameCount(); ++k) EXPECT_NEAR(take.timeOf(k), k / 30.0, 1e-6);
  std::vector<std::vector<std::uint8_t>> background(3, std::vector<std::uint8_t>(3 * 64 * 48));
  take.readBackground(std::vector<std::span<std::uint8_t>>(background.begin(), background.end()));
  for (std::size_t c = 0; c < 3; ++c)
    EXPECT_EQ(int(background[c][0]), int(Videos::grey(c, 2))) << "the mean of frames 0 to 4";
}

TEST(RecordApp, SecondsLimitARecordingForCalibration) {
  const Videos videos;
  const json figures = jsonOf(videos.record({"--seconds", "0.5", "--json"}));
  EXPECT_NEAR(figures["seconds"], 0.5, 0.04);
  EXPECT_NEAR(figures["sets"], 16, 1);
  EXPECT_FALSE(fs::exists(videos.folder / "take/rig.toml"));
  writeRig(videos.folder / "take/rig.toml", videos.rig);
  Take take(videos.out());
  EXPECT_EQ(take.frameCount(), figures["sets"]);
  expectFrames(take, videos.rig, 0);
}

TEST(RecordApp, CtrlCLeavesAReadableTake) {
  const Videos videos;
  RunOptions options;
  options.interrupt_when = [&] { return contentOf(videos.folder / "take/timestamps.csv").size() > 200; };
  const RunResult result = runAirclay(videos.withRig({"--loop"}), options);
  EXPECT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(result.errors, "");
  EXPECT_NE(result.output.find(" sets, "), std::string::npos) << result.output;
  Take take(videos.out());  // complete: not read as an interrupted take
  EXPECT_GT(take.frameCount(), 2);
}

TEST(RecordApp, LostCameraLeavesAReadableTake) {
  const TemporaryFolder folder;
  auto far = std::make_unique<MjpegServer>(ImageSize{64, 48}, 30);
  MjpegServer near({64, 48}, 30);
  const auto camera = [](const std::string& name, int port) {
    return name + "=http://127.0.0.1:" + std::to_string(port) + "/";
  };
  Process program({AIRCLAY_PROGRAM, "record", "--camera", camera("near", near.port()), "--camera",
                   camera("far", far->port()), "--max-skew-ms", "100", "--out", folder / "take"},
                  {}, folder / "output", folder / "errors");
  ASSERT_TRUE(waitUntil([&] { return contentOf(folder / "take/timestamps.csv").size() > 400; }))
      << contentOf(folder / "errors");
  far.reset();
  ASSERT_EQ(program.waitForExit(), 1);
  const std::string errors = contentOf(folder / "errors");
  EXPECT_NE(errors.find("camera \"far\" has been "), std::string::npos) << errors;
  EXPECT_NE(errors.find("sets, which are readable"), std::string::npos) << errors;
  Rig rig = ringRig(2, 64, 48);
  rig.cameras[0].name = "near";
  rig.cameras[1].name = "far";
  writeRig(folder / "take/rig.toml", rig);
  EXPECT_GT(Take(folder / "take").frameCount(), 2);
}

TEST(RecordApp, InvalidUseIsAOneLineError) {
  const Videos videos;
  expectRefused({"record", "--out", videos.out()}, 2, "--camera");
  expectRefused({"record", "--camera", "left", "--out", videos.out()}, 2, "NAME=SOURCE");
  expectRefused({"record", "--camera", "left=none.mp4", "--out", videos.out()}, 1,
                "camera \"left\" (none.mp4)");
  expectRefused({"record", "--camera", "cam0=" + videos.file("cam0"), "--rig",
                 (videos.folder / "source/rig.toml").string(), "--out", videos.out()},
                2, "cam1");
  expectRefused(videos.record({"--seconds", "-1"}), 2, "--seconds");
  expectRefused(videos.record({"--offset", "top=3"}), 2, "--offset");
  expectRefused(videos.record({"--mode", "wide"}), 2, "--mode");
  EXPECT_FALSE(fs::exists(videos.out()));
  Strings into_full = videos.record({});
  into_full[2] = (videos.folder / "source").string();
  expectRefused(into_full, 1, "the folder is not empty");
  const Rig larger = ringRig(3, 128, 96);
  writeRig(videos.folder / "larger.toml", larger);
  expectRefused(videos.record({"--rig", (videos.folder / "larger.toml").string()}), 1, "64 x 48");
}

TEST(CamerasApp, ListsOpensAndWatches) {
  EXPECT_TRUE(jsonOf({"cameras", "--json"})["devices"].is_array());
  const bool no_devices = jsonOf({"cameras", "--json"})["devices"].empty();
  EXPECT_EQ(runAirclay({"cameras"}).output.find("rtsp://") != std::string::npos, no_devices);
  const Videos videos;
  const Strings arguments = {
      "cameras", "--camera", "left=" + videos.file("cam0"), "--camera", "right=" + videos.file("cam1"),
      "--json"};
  const json opened = jsonOf(arguments);
  ASSERT_EQ(opened["cameras"].size(), 2u);
  EXPECT_EQ(opened["cameras"][1]["name"], "right");
  EXPECT_EQ(opened["cameras"][0]["width"], 64);
  EXPECT_NEAR(opened["cameras"][0]["rate_hz"], 30, 1e-6);
  Strings watching = arguments;
  watching.insert(watching.end(), {"--loop", "--watch", "2"});
  const json watched = jsonOf(watching);
  EXPECT_EQ(watched["cameras"][0]["state"], "live");
  EXPECT_GT(watched["cameras"][0]["frames"], 20);
  EXPECT_GT(watched["sets"], 10);
  EXPECT_NEAR(watched["skew_ms"]["worst"], 0, 0.01);
  expectRefused({"cameras", "--watch"}, 2, "--camera");
  expectRefused({"cameras", "--camera", "left=/dev/video63"}, 1, "camera \"left\"");
}

}  // namespace
}  // namespace airclay
