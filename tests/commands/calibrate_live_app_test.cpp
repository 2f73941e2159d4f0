// SPDX-License-Identifier: MIT
// `airclay calibrate` and `recalibrate` with live cameras: videos of a moving board, played like
// cameras.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "capture/images/video_writer.h"
#include "engine/camera/rig_formats.h"
#include "tests/support/board_scene.h"
#include "tests/support/calibration_scene.h"
#include "tests/support/desktop.h"
#include "tests/support/scene.h"

namespace airclay {
namespace {

using nlohmann::json;
using Strings = std::vector<std::string>;

constexpr int kWidth = 320, kHeight = 240;
constexpr int kPositions = 32, kFramesEach = 7;

class CalibrateLive : public testing::Test {
 protected:
  CalibrateLive() : rig(ringRig(12, kWidth, kHeight)) {
    rig.cameras.resize(2);
    board.square_m = 0.06;
    board.marker_m = 0.045;
  }

  /// The board rests for a quarter of a second at several places.
  void film(bool with_board = true) const {
    std::vector<VideoWriter> videos;
    for (const Camera& camera : rig.cameras) videos.push_back(writerFor(camera.name));
    for (int i = 0; i < kPositions; ++i) {
      const double a = 0.37 * i, b = 0.23 * i;
      const Vec3 turn(0.5 * std::sin(a), 0.5 * std::cos(b), 0.3 * std::sin(b));
      const Vec3 place(0.16 * std::sin(b), 0.12 * std::cos(a), with_board ? 0.1 * std::sin(0.5 * a) : 40);
      const Pose pose = boardBefore(board, rig.cameras[std::size_t(i % 2)], 0.75, turn, place);
      for (std::size_t c = 0; c < 2; ++c) {
        const std::vector<std::uint8_t> bgr = drawBoard(board, rig.cameras[c], pose, {.noise_sigma = 2});
        for (int k = 0; k < kFramesEach; ++k) videos[c].write(bgr);
      }
    }
    for (VideoWriter& video : videos) video.finish();
  }
  VideoWriter writerFor(const std::string& name) const {
    VideoWriter::Options options;
    options.size = {kWidth, kHeight};
    options.rate_hz = 30;
    options.format = VideoWriter::Format::kBgr8;
    return VideoWriter(folder / (name + ".mp4"), options);
  }
  Strings arguments(const Strings& command, const Strings& more) const {
    Strings all = command;
    for (const Camera& camera : rig.cameras)
      all.insert(all.end(), {"--camera", camera.name + "=" + (folder / (camera.name + ".mp4")).string()});
    all.insert(all.end(), {"--square-mm", "60", "--marker-mm", "45", "--out", out()});
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  std::string out() const { return folder / "found.toml"; }
  static void expectRefused(const RunResult& result, int status, const std::string& expected) {
    EXPECT_EQ(result.status, status) << result.output;
    ASSERT_EQ(result.errorLines().size(), 1u) << result.errors;
    EXPECT_NE(result.errors.find(expected), std::string::npos) << result.errors;
  }

  TemporaryFolder folder;
  Rig rig;
  Board board;
};

TEST_F(CalibrateLive, CollectsViewsWithoutAWindow) {
  film();
  const RunResult result = runAirclay(arguments({"calibrate"}, {"--headless", "--json", "--loop"}));
  ASSERT_EQ(result.status, 0) << result.errors;
  const json report = json::parse(result.output);
  ASSERT_EQ(report["cameras"].size(), 2u);
  for (const json& camera : report["cameras"]) EXPECT_GE(camera["views"], kFewestViews);
  EXPECT_LT(report["rms_px"], 0.2);
  const CubeError error = cubeError(rig, readRig(out()));
  EXPECT_LT(error.central_mm, 0.5);
  EXPECT_NEAR(error.scale, 1, 2e-3);

  // the second camera was moved: its rig states the former place
  Rig old = readRig(out());
  const Rig truth = old;
  old.cameras[1] = bumped(old.cameras[1], Vec3(0.012, -0.004, 0.003), Vec3(0.01, 0.02, -0.01));
  const std::string old_file = folder / "old.toml";
  writeRig(old_file, old);
  const RunResult again =
      runAirclay(arguments({"recalibrate", old_file}, {"--headless", "--json", "--loop"}));
  ASSERT_EQ(again.status, 0) << again.errors;
  EXPECT_LT(cubeError(truth, readRig(out())).central_mm, 0.5);
  const json refound = json::parse(again.output);
  EXPECT_GT(refound["rms_px_before"].get<double>(), 5 * refound["rms_px"].get<double>());
}

TEST_F(CalibrateLive, MissingBoardIsAOneLineError) {
  film(false);
  expectRefused(runAirclay(arguments({"calibrate"}, {"--headless", "--quiet"})), 1, "cam0");
  EXPECT_FALSE(std::filesystem::exists(out()));
}

TEST_F(CalibrateLive, RejectsInvalidUse) {
  expectRefused(runAirclay({"calibrate", "--out", out()}), 2, "--camera NAME=SOURCE");
  expectRefused(runAirclay(arguments({"calibrate", folder.path().string()}, {})), 2, "TAKE or --camera");
  expectRefused(runAirclay(arguments({"calibrate"}, {"--headless", "--world", "3"})), 2, "--world");
  expectRefused(runAirclay(arguments({"calibrate"}, {"--headless"})), 1, "cam0.mp4");
}

class CalibrateWindow : public CalibrateLive {
 protected:
  void SetUp() override {
    if (!Desktop::possible()) GTEST_SKIP() << "Xvfb is missing; third_party/packages.txt lists the packages";
    film();
  }
  void start(const Strings& more) { open(arguments({"calibrate"}, more)); }
  void open(const Strings& command) {
    Strings all = {AIRCLAY_PROGRAM};
    all.insert(all.end(), command.begin(), command.end());
    std::map<std::string, std::string> environment = desktop.environment();
    environment["AIRCLAY_VALIDATION"] = "1";
    program.emplace(all, environment, folder / "output", folder / "errors");
    desktop.findWindow("^Airclay");
  }

  Desktop desktop;
  std::optional<Process> program;
};

TEST_F(CalibrateWindow, ShowsCamerasAndMakesTheRig) {
  start({"--loop"});
  const Screenshot first = desktop.screenshot();
  ASSERT_TRUE(waitUntil([&] { return differingFraction(first, desktop.screenshot(), 0.9) > 0.05; }))
      << "the cameras' images change";
  desktop.key("w");
  // too few views at first: the window says so and continues
  ASSERT_TRUE(waitUntil([&] {
    desktop.key("Return");
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    return std::filesystem::exists(out());
  })) << contentOf(folder / "errors");
  desktop.key("Escape");
  EXPECT_EQ(program->waitForExit(), 0) << contentOf(folder / "errors");
  const CubeError error = cubeError(rig, readRig(out()));
  EXPECT_LT(error.central_mm, 2);
  EXPECT_NE(contentOf(folder / "output").find("px RMS"), std::string::npos);
  for (const std::string& line : {std::string("VUID"), std::string("Validation")})
    EXPECT_EQ(contentOf(folder / "errors").find(line), std::string::npos) << contentOf(folder / "errors");
}

TEST_F(CalibrateWindow, WatchesCameras) {
  Strings watch = {"cameras", "--watch", "--loop"};
  for (const Camera& camera : rig.cameras)
    watch.insert(watch.end(), {"--camera", camera.name + "=" + (folder / (camera.name + ".mp4")).string()});
  open(watch);
  const Screenshot first = desktop.screenshot();
  EXPECT_TRUE(waitUntil([&] { return differingFraction(first, desktop.screenshot(), 0.9) > 0.02; }));
  EXPECT_TRUE(waitUntil([&] { return contentOf(folder / "output").find("live") != std::string::npos; }))
      << contentOf(folder / "output");
  desktop.key("Escape");
  EXPECT_EQ(program->waitForExit(), 0);
  EXPECT_EQ(contentOf(folder / "errors"), "");
}

TEST_F(CalibrateWindow, ClosingEarlyReportsThatNoRigWasMade) {
  start({"--loop"});
  desktop.key("Escape");
  EXPECT_EQ(program->waitForExit(), 1);
  EXPECT_EQ(contentOf(folder / "errors"),
            "airclay: the window was closed before the calibration finished; nothing was written\n");
  EXPECT_FALSE(std::filesystem::exists(out()));
}

}  // namespace
}  // namespace airclay
