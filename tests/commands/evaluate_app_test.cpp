// SPDX-License-Identifier: MIT
// `airclay evaluate` on rendered takes: the reported errors are those of the poses that `airclay track`
// writes.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "capture/images/image_file.h"
#include "capture/takes/evaluation.h"
#include "capture/takes/take.h"
#include "capture/takes/truth.h"
#include "tests/support/program.h"
#include "tests/support/small_take.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

using nlohmann::json;

/// A small take with its ground truth.
struct TrueTake {
  TemporaryFolder folder;
  std::vector<TimedPose> truth;

  TrueTake() {
    const int frames = writeSmallTake(folder / "desk");
    for (int frame = 0; frame < frames; ++frame)
      if (const std::optional<Pose> pose = smallTakeScript().at(frame / 30.0))
        truth.push_back({frame / 30.0, *pose});
    writePoses(folder / "desk/truth.tum", truth);
  }
  std::string path() const { return (folder / "desk").string(); }
  std::string out() const { return (folder / "out").string(); }
};

/// `options`: of the fit, for example.
json evaluated(const std::vector<std::string>& takes, const std::string& out,
               const std::vector<std::string>& options = {}) {
  std::vector<std::string> arguments = {"evaluate", "--json", "--voxels", "64", "--out", out};
  arguments.insert(arguments.begin() + 1, takes.begin(), takes.end());
  arguments.insert(arguments.end(), options.begin(), options.end());
  const RunResult result = runAirclay(arguments);
  EXPECT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(result.errors, "");
  return json::parse(result.output);
}

TEST(EvaluateApp, ReportsTheErrorsOfTheTrackedPoses) {
  const TrueTake take;
  const std::string poses = take.folder / "poses.tum";
  ASSERT_EQ(runAirclay({"track", take.path(), "--poses", poses, "--voxels", "64", "--quiet"}).status, 0);
  std::vector<double> mm;
  const Vec3 center = handCenter(builtInHand(false));
  for (const TimedPose& pose : readPoses(poses)) {
    const std::optional<Pose> truth = nearestPose(take.truth, pose.time_s, 1.0 / 30);
    ASSERT_TRUE(truth);
    mm.push_back(1000 * (pose.world_from_hand * center - *truth * center).norm());
  }
  std::sort(mm.begin(), mm.end());

  const json figures = evaluated({take.path()}, take.out());
  ASSERT_EQ(figures["takes"].size(), 1u);
  const json& desk = figures["takes"][0];
  std::vector<std::string> keys;
  for (const auto& [key, value] : desk.items()) keys.push_back(key);
  std::vector<std::string> expected = {"name",
                                       "frames",
                                       "tracked",
                                       "uncertain",
                                       "lost",
                                       "wrong_tracked",
                                       "mm_median",
                                       "mm_p90",
                                       "mm_p99",
                                       "mm_worst",
                                       "deg_median",
                                       "deg_p90",
                                       "deg_p99",
                                       "deg_worst",
                                       "jitter_mm",
                                       "jitter_deg",
                                       "frames_to_find",
                                       "inside_68_percent",
                                       "inside_95_percent"};
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(keys, expected);
  EXPECT_EQ(desk["name"], "desk");
  EXPECT_EQ(desk["frames"], take.truth.size());
  EXPECT_EQ(desk["tracked"], mm.size());
  EXPECT_EQ(desk["lost"], take.truth.size() - mm.size());
  EXPECT_NEAR(desk["mm_median"], percentile(mm, 0.5), 1e-3);  // the file has seven decimals
  EXPECT_NEAR(desk["mm_p90"], percentile(mm, 0.9), 1e-3);
  EXPECT_NEAR(desk["mm_worst"], mm.back(), 1e-3);
  EXPECT_EQ(desk["frames_to_find"], 0);
  EXPECT_GT(imageSize(take.folder / "out/desk.png").width, 800);
}

TEST(EvaluateApp, DenseTruthReplacesTheFramesTruth) {
  const TrueTake take;
  // the published fit never calls a pose uncertain
  const std::vector<std::string> paper = {"--fit", "paper", "--silhouettes", "paper"};
  const json before = evaluated({take.path()}, take.out(), paper);
  std::vector<TimedPose> shifted = take.truth;
  // One more pose at each end, so that every frame is between two.
  shifted.insert(shifted.begin(), {shifted.front().time_s - 1 / 30.0, shifted.front().world_from_hand});
  shifted.push_back({shifted.back().time_s + 1 / 30.0, shifted.back().world_from_hand});
  for (TimedPose& pose : shifted) pose.world_from_hand.pretranslate(Vec3(0, 0, 0.1));
  writePoses(take.folder / "desk/truth_dense.tum", shifted);
  const json after = evaluated({take.path(), take.path()}, take.out(), paper)["takes"];
  ASSERT_EQ(after.size(), 2u);
  EXPECT_EQ(after[0]["name"], "desk");
  EXPECT_EQ(after[1]["name"], "desk-2");
  EXPECT_EQ(after[0]["mm_median"], after[1]["mm_median"]);  // each take starts from nothing
  EXPECT_NEAR(after[0]["mm_median"], 100, 5);
  EXPECT_EQ(after[0]["wrong_tracked"], after[0]["tracked"]);
  EXPECT_TRUE(after[0]["frames_to_find"].is_null());
  // The file's times have six decimals.
  EXPECT_NEAR(after[0]["deg_median"], before["takes"][0]["deg_median"], 1e-5);
  EXPECT_TRUE(std::filesystem::exists(take.folder / "out/desk-2.png"));
}

void expectError(const std::vector<std::string>& arguments, int status, const std::string& expected) {
  const RunResult result = runAirclay(arguments);
  EXPECT_EQ(result.status, status);
  EXPECT_EQ(result.output, "");
  ASSERT_EQ(result.errorLines().size(), 1u) << result.errors;
  EXPECT_NE(result.errors.find(expected), std::string::npos) << result.errors;
}

TEST(EvaluateApp, TruthIsRequiredAndChecked) {
  const TemporaryFolder folder;
  const std::string path = folder.path().string(), out = folder / "out";
  expectError({"evaluate", "--out", out}, 2, "TAKE");
  expectError({"evaluate", path + "/none", "--out", out}, 1, "none: there is no such take");
  expectError({"evaluate", path, "--out", out}, 1, path + ": the take has no ground truth");
  folder.write("truth.tum", "0.1 0 0 0 0 0 0 1\n0.2 0 0 zero 0 0 0 1\n");
  expectError({"evaluate", path, "--out", out}, 1, "/truth.tum:2: ");
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST(EvaluateApp, SyntheticTakesAreRenderedTrackedAndWritten) {
  const TemporaryFolder folder;
  const RunResult result =
      runAirclay({"evaluate", "--synthetic", "--only", "clean-2", "--keep", folder / "takes", "--voxels",
                  "64", "--json", "--out", folder / "out"});
  EXPECT_EQ(result.status, 0) << result.errors;
  const json takes = json::parse(result.output)["takes"];
  ASSERT_EQ(takes.size(), 1u);
  EXPECT_EQ(takes[0]["name"], "clean-2");
  EXPECT_GT(takes[0]["frames"], 60);
  EXPECT_TRUE(std::filesystem::exists(folder / "out/clean-2.png"));
  EXPECT_EQ(readTruth(folder / "takes/clean-2").frames.size(), takes[0]["frames"]);
  EXPECT_EQ(Take(folder / "takes/clean-2").rig().cameras.size(), 2u);
}

TEST(EvaluateApp, SyntheticTakesAreSelectedByName) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  expectError({"evaluate", "--synthetic", "--only", "cleaner", "--out", out}, 2,
              "expected one of clean-2, clean-4");
  expectError({"evaluate", "--synthetic", folder.path(), "--out", out}, 2, "--synthetic");
  expectError({"evaluate", folder.path(), "--only", "clean-2", "--out", out}, 2, "--synthetic");
  EXPECT_FALSE(std::filesystem::exists(out));
}

}  // namespace
}  // namespace airclay
