// SPDX-License-Identifier: MIT
// `airclay sculpt` with live cameras: folders of images, played in real time.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "capture/takes/poses_file.h"
#include "engine/camera/rig.h"
#include "engine/clay/presets.h"
#include "engine/mesh/mesh_file.h"
#include "tests/support/program.h"
#include "tests/support/small_take.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

using Strings = std::vector<std::string>;

// The program must be ready before the hand appears: 12 s, for the validation layer and a loaded machine. The
// hand pauses until it is found, which takes half a second on a CPU device.
const SmallTake kUnhurried{.empty_frames = 360, .slower = 6};

class LiveApp : public testing::Test {
 protected:
  std::string at(const std::string& name) const { return folder / name; }
  RunResult sculpt(const Strings& more) const {
    Strings arguments = {"sculpt", "--headless"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return runAirclay(arguments, {.environment = {{"AIRCLAY_VALIDATION", "1"}}});
  }
  /// Options that use the take's folders as cameras.
  Strings live(const std::string& take) const {
    Strings arguments = {"--rig", at(take + "/rig.toml")};
    for (const Camera& camera : readRig(at(take + "/rig.toml")).cameras)
      arguments.insert(arguments.end(), {"--camera", camera.name + "=" + at(take + "/" + camera.name)});
    return arguments;
  }

  TemporaryFolder folder;
};

/// The largest distance of a pose from the hand's path.
double farthestFrom(const HandScript& script, double until_s, const std::vector<TimedPose>& poses) {
  double farthest_m = 0;
  for (const TimedPose& pose : poses) {
    double nearest_m = INFINITY;
    for (double t = 0; t < until_s; t += 0.002)
      if (const std::optional<Pose> truth = script.at(t))
        nearest_m = std::min(nearest_m, (truth->translation() - pose.world_from_hand.translation()).norm());
    farthest_m = std::max(farthest_m, nearest_m);
  }
  return farthest_m;
}

TEST_F(LiveApp, SculptsWithLiveCameras) {
  const int frames = writeSmallTake(folder / "take", kUnhurried);
  Strings arguments = live("take");
  arguments.insert(arguments.end(), {"--out", at("out"), "--record", at("recorded"), "--no-filter"});
  const RunResult result = sculpt(arguments);
  ASSERT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(result.errors, "");
  const std::vector<TimedPose> poses = readPoses(at("out/poses.tum"));
  EXPECT_GT(poses.size(), 5u) << result.output;  // a slow machine skips frames
  // images of 320 x 240: a pixel is 4 mm wide
  EXPECT_LT(farthestFrom(smallTakeScript(kUnhurried), frames / 30.0, poses), 0.008);
  const PolygonMesh cage = readObj(at("out/cage.obj")), tube = presetCage("tube");
  double moved_m = 0;
  for (std::size_t i = 0; i < cage.points.size(); ++i)
    moved_m = std::max(moved_m, (cage.points[i] - tube.points[i]).norm());
  EXPECT_GT(moved_m, 0.003);

  // replaying its recording gives the same clay
  const RunResult again = runAirclay({"sculpt", at("recorded"), "--headless", "--out", at("again")});
  EXPECT_EQ(again.status, 0) << again.errors;
  EXPECT_EQ(contentOf(folder / "out/cage.obj"), contentOf(folder / "again/cage.obj"));
  EXPECT_EQ(contentOf(folder / "out/surface.obj"), contentOf(folder / "again/surface.obj"));
}

TEST_F(LiveApp, EstimatesClockOffsets) {
  // back and forth in the workspace, on a path without repetition
  SmallTake free;
  for (int i = 0; i < 12; ++i)
    free.way.emplace_back(0.08 * std::sin(2.1 * i), 0.06 * std::cos(1.3 * i), 0.05 * std::sin(0.9 * i * i));
  const int frames = writeSmallTake(folder / "take", free);
  const std::vector<Camera> cameras = readRig(at("take/rig.toml")).cameras;
  const std::vector<double> offsets_s = {0, 0.004, -0.006, 0.009};
  ASSERT_EQ(cameras.size(), offsets_s.size());
  std::ostringstream times;
  times.precision(12);
  times << "cam_id,frame_time\n";
  for (int frame = 0; frame < frames; ++frame)
    for (std::size_t c = 0; c < cameras.size(); ++c)
      times << cameras[c].name << "," << frame / 30.0 + offsets_s[c] << "\n";
  folder.write("take/timestamps.csv", times.str());
  const RunResult result = runAirclay({"offsets", at("take"), "--json"});
  ASSERT_EQ(result.status, 0) << result.errors;
  const nlohmann::json report = nlohmann::json::parse(result.output);
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    EXPECT_EQ(report["cameras"][c]["name"], cameras[c].name);
    EXPECT_NEAR(report["cameras"][c]["offset_ms"].get<double>(), 1000 * offsets_s[c], 2) << c;
  }
  // without timestamps, equal numbers are taken to be equal times: here they are
  std::filesystem::remove(folder / "take/timestamps.csv");
  const RunResult none = runAirclay({"offsets", at("take"), "--json"});
  ASSERT_EQ(none.status, 0) << none.errors;
  for (const nlohmann::json& camera : nlohmann::json::parse(none.output)["cameras"])
    EXPECT_NEAR(camera["offset_ms"].get<double>(), 0, 2) << camera["name"];
}

TEST_F(LiveApp, InvalidUseIsAOneLineError) {
  writeSmallTake(folder / "take");
  const auto refused = [&](const Strings& arguments, int status, const std::string& expected) {
    const RunResult result = sculpt(arguments);
    EXPECT_EQ(result.status, status) << expected;
    EXPECT_EQ(result.errorLines().size(), 1u) << result.errors;
    EXPECT_NE(result.errors.find(expected), std::string::npos) << result.errors;
  };
  const Strings all = live("take");
  const auto with = [&](Strings arguments, const Strings& more) {
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  };
  refused({all.begin() + 2, all.end()}, 2, "--rig");
  refused({all.begin(), all.end() - 2}, 2, "has no source");
  refused(with(all, {"--camera", "other=" + at("take/other")}), 2, "no camera with this name");
  refused(with(all, {at("take")}), 2, "exclude each other");
  Strings gone = all;
  gone.back() = gone.back() + "-gone";
  refused(gone, 1, "-gone");
}

}  // namespace
}  // namespace airclay
