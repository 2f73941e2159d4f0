// SPDX-License-Identifier: MIT
// TUM trajectories: round trips keep the format's digits; invalid files are rejected with their
// line.
#include "capture/takes/poses_file.h"

#include <gtest/gtest.h>

#include <sstream>

#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

TEST(PosesFile, ReadsTumOrder) {
  const TemporaryFolder folder;
  // A quarter turn about z: (qx qy qz qw) = (0 0 √½ √½).
  const std::vector<TimedPose> poses = readPoses(folder.write(
      "truth.tum",
      "# timestamp tx ty tz qx qy qz qw\n\n1.5 0.1 -0.2 3e-1 0 0 0.7071067811865476 0.7071067811865476\r\n"
      "2 0 0 0 0 0 0 1\n"));
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses[0].time_s, 1.5);
  EXPECT_TRUE((poses[0].world_from_hand * Vec3(1, 0, 0)).isApprox(Vec3(0.1, 0.8, 0.3), 1e-15));
  EXPECT_TRUE(poses[1].world_from_hand.isApprox(Pose::Identity(), 1e-15));
}

TEST(PosesFile, RoundTripKeepsAllDigits) {
  const TemporaryFolder folder;
  std::vector<TimedPose> poses;
  for (int i = 0; i < 50; ++i) {
    TimedPose pose;
    pose.time_s = 1234.5 + i / 30.0;
    pose.world_from_hand.linear() = rotationFromVector(Vec3(0.11 * i, -0.07 * i, 3.0 - 0.2 * i));
    pose.world_from_hand.translation() = Vec3(0.3 / (i + 1), -0.01 * i, 1e-6 * i);
    poses.push_back(pose);
  }
  writePoses(folder / "poses.tum", poses);
  const std::vector<TimedPose> again = readPoses(folder / "poses.tum");
  ASSERT_EQ(again.size(), poses.size());
  for (size_t i = 0; i < poses.size(); ++i) {
    EXPECT_NEAR(again[i].time_s, poses[i].time_s, 0.51e-6);
    const Vec3 miss = again[i].world_from_hand.translation() - poses[i].world_from_hand.translation();
    EXPECT_LE(miss.cwiseAbs().maxCoeff(), 0.51e-7);
    EXPECT_LE(angleBetween(again[i].world_from_hand.linear(), poses[i].world_from_hand.linear()), 4e-9);
  }
  std::ifstream in(folder / "poses.tum");
  for (std::string line; std::getline(in, line);) {
    std::istringstream fields(line);
    std::string field;
    int count = 0;
    while (fields >> field) ++count;
    EXPECT_EQ(count, 8) << line;
    EXPECT_EQ(field.front() == '-', false) << line;  // qw >= 0
  }
}

TEST(PosesFile, RejectsMalformedPoses) {
  const TemporaryFolder folder;
  const std::string good = "0 0 0 0 0 0 0 1\n";
  const std::vector<std::pair<std::string, std::string>> cases{
      {"1 0 0 0 0 0 1\n", ":2:"},          {"1 0 0 0 0 0 0 1 0\n", ":2:"},
      {"1 0 0 x 0 0 0 1\n", ":2:"},        {"1 0 0 nan 0 0 0 1\n", "finite"},
      {"1,0,0,0,0,0,0,1\n", ":2:"},        {"1 0 0 0 0 0 0 0\n", "length"},
      {"1 0 0 0 0 0 0.1 1\n", "length"},   {"0 0 0 0 0 0 0 1\n", "increasing"},
      {"1 0 0 1e999 0 0 0 1\n", "finite"},
  };
  for (const auto& [bad, mention] : cases) {
    const std::filesystem::path file = folder.write("bad.tum", good + bad);
    const std::string message = messageOf([&] { readPoses(file); });
    EXPECT_EQ(message.find(file.string() + ":2: "), 0u) << bad << message;
    EXPECT_NE(message.find(mention), std::string::npos) << bad << message;
  }
  EXPECT_NE(messageOf([&] { readPoses(folder.write("empty.tum", "# none\n")); }), "");
  EXPECT_NE(messageOf([&] { readPoses(folder / "none.tum"); }), "");
  EXPECT_NE(messageOf([&] { readPoses(folder.path()); }), "");
  EXPECT_NE(messageOf([&] { writePoses(folder / "no/such/folder.tum", {TimedPose{}}); }), "");
}

}  // namespace
}  // namespace airclay
