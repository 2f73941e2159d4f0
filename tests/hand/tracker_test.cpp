// SPDX-License-Identifier: MIT
#include "engine/hand/tracker.h"

#include <iostream>
#include <random>

#include "tests/support/gpu_fixture.h"
#include "tests/support/hand_scene.h"
#include "tests/support/scene.h"

namespace airclay {
namespace {

/// Uniform over all rotations (Shoemake 1992: a normalized Gaussian quaternion).
Eigen::Quaterniond randomRotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
}

/// Carver and tracker of one rig, from masks to poses.
struct Tracking {
  GpuRig rig;
  Buffer<std::uint32_t> masks;
  Carver carver;
  HandTracker tracker;
  Recorder recorder;
  std::vector<std::pair<std::string, double>> stage_ms;

  Tracking(const Rig& r, const HandModel& hand, int voxels = 128)
      : rig(testGpu(), r),
        masks(testGpu(), rig.maskWords(), Memory::kHost),
        carver(testGpu(), rig, voxels),
        tracker(testGpu(), rig, hand, carver),
        recorder(testGpu()) {}

  void carve(const std::vector<Silhouette>& images) {
    rig.pack(images, masks.host());
    recorder.begin();
    carver.record(recorder, masks);
    recorder.submitAndWait();
  }
  HandFit follow() {
    recorder.begin();
    tracker.recordTracking(recorder);
    recorder.submitAndWait();
    EXPECT_TRUE(hazards(recorder.commands()).empty());
    return tracker.finish();
  }
  /// As in the pipeline for a frame without a last pose.
  HandFit search(const std::vector<Silhouette>& images) {
    carve(images);
    return tracker.search(recorder, stage_ms) ? follow() : HandFit{};
  }
};

/// The hand's largest distance from the workspace's centre.
double reach(const HandModel& hand, const Pose& world_from_hand) {
  double farthest = 0;
  for (const Vec3& vertex : hand.skin.vertices)
    farthest = std::max(farthest, (world_from_hand * vertex).norm());
  return farthest;
}

TEST(Tracker, SearchRotationsCoverAllOrientations) {
  const std::vector<Eigen::Quaterniond> rotations = uniformRotations(600);
  ASSERT_EQ(rotations.size(), 600u);
  std::mt19937 random(3);
  double largest_gap = 0, sum = 0;
  constexpr int samples = 5000;
  for (int i = 0; i < samples; ++i) {
    const Eigen::Quaterniond q = randomRotation(random);
    double nearest = M_PI;
    for (const Eigen::Quaterniond& rotation : rotations)
      nearest = std::min(nearest, 2 * std::acos(std::min(1.0, std::abs(q.dot(rotation)))));
    largest_gap = std::max(largest_gap, nearest * 180 / M_PI);
    sum += nearest * 180 / M_PI;
  }
  EXPECT_LT(largest_gap, 35);
  EXPECT_LT(sum / samples, 20);
  for (const Eigen::Quaterniond& rotation : rotations) EXPECT_NEAR(rotation.norm(), 1, 1e-12);
}

// Rig and truth rotate together, so the images stay the same while the orientation, the workspace's corners
// and the voxel grid differ each time.
TEST(Tracker, FindsTheHandInAnyOrientation) {
  const HandModel hand = builtInHand(false);
  HandCameras cameras;
  const HandScript script = demoScript();
  std::mt19937 random(11);
  int tries = 0, found = 0;
  for (const double time_s : {0.5, 1.5, 2.1, 3.4, 4.6}) {
    Pose truth = *script.at(time_s);
    truth.translation() *= 0.4;  // so that it stays in the workspace when rotated
    ASSERT_LT(reach(hand, truth), 0.29);
    const std::vector<Silhouette> masks = cameras.masks(truth);
    for (int i = 0; i < 20; ++i, ++tries) {
      const Eigen::Quaterniond turn = randomRotation(random);
      Tracking tracking(turned(cameras.rig().rig(), turn), hand);
      const HandFit fit = tracking.search(masks);
      const PoseError error =
          poseError(fit.pose.world_from_hand, Pose(turn) * truth, tracking.tracker.model().center_of_mass);
      found += fit.tracked && error.shift_m < 0.010 && error.turn_degrees < 5;
    }
  }
  std::cout << found << " of " << tries << " orientations found\n";
  EXPECT_EQ(tries, 100);
  EXPECT_GE(found, 90);
}

TEST(Tracker, FollowsTheHandFromItsLastPose) {
  HandCameras cameras;
  const HandScript script = demoScript();
  Tracking tracking(cameras.rig().rig(), builtInHand(false));
  const Vec3& center_of_mass = tracking.tracker.model().center_of_mass;
  // the rotation from the side to above: the fastest motion of the script
  constexpr int first = 88, last = 112;
  for (int frame = first; frame <= last; ++frame) {
    SCOPED_TRACE("frame " + std::to_string(frame));
    const Pose truth = *script.at(frame / kDemoRateHz);
    const std::vector<Silhouette> masks = cameras.masks(truth);
    HandFit fit;
    if (frame == first) {
      fit = tracking.search(masks);
    } else {
      tracking.carve(masks);
      ASSERT_TRUE(tracking.tracker.hasPose());
      fit = tracking.follow();
    }
    ASSERT_TRUE(fit.tracked);
    const PoseError error = poseError(fit.pose.world_from_hand, truth, center_of_mass);
    EXPECT_LT(error.shift_m, 0.004);
    EXPECT_LT(error.turn_degrees, 3);
    EXPECT_LT(fit.outside_m, 0.001);
    EXPECT_LE(fit.iterations, FitLimits{}.iterations);
  }
}

TEST(Tracker, LeftHandModelFindsTheLeftHand) {
  HandCameras cameras(demoRig(), {builtInHand(true).skin, builtInForearm(true)});
  Tracking tracking(cameras.rig().rig(), builtInHand(true));
  const Pose truth = *demoScript().at(3.4);
  const HandFit fit = tracking.search(cameras.masks(truth));
  ASSERT_TRUE(fit.tracked);
  const PoseError error = poseError(fit.pose.world_from_hand, truth, tracking.tracker.model().center_of_mass);
  EXPECT_LT(error.shift_m, 0.004);
  EXPECT_LT(error.turn_degrees, 3);
}

TEST(Tracker, EmptyHullGivesNoHand) {
  const Rig rig = demoRig();
  Tracking tracking(rig, builtInHand(false));
  // an empty hull, and one of a few millimetres
  for (const double radius_m : {-1.0, 0.006}) {
    EXPECT_FALSE(tracking.search(sphereMasks(rig, Vec3(0.05, 0, 0.02), radius_m)).tracked);
    EXPECT_TRUE(tracking.tracker.isEmpty());
    EXPECT_FALSE(tracking.tracker.hasPose());
  }
  // a ball is as large as a hand, but too short
  EXPECT_FALSE(tracking.search(sphereMasks(rig, Vec3(0.05, 0, 0.02), 0.06)).tracked);
  EXPECT_FALSE(tracking.tracker.isEmpty());
  EXPECT_FALSE(tracking.tracker.hasPose());
}

TEST(Tracker, ForgetsAHandThatLeaves) {
  HandCameras cameras;
  const Rig rig = cameras.rig().rig();
  Tracking tracking(rig, builtInHand(false));
  const std::vector<Silhouette> masks = cameras.masks(*demoScript().at(0.5));
  ASSERT_TRUE(tracking.search(masks).tracked);
  tracking.carve(sphereMasks(rig, Vec3::Zero(), -1));
  EXPECT_FALSE(tracking.follow().tracked);
  EXPECT_FALSE(tracking.tracker.hasPose());
  EXPECT_TRUE(tracking.search(masks).tracked);
  // at another place it is not mistaken for the previous one
  ASSERT_TRUE(tracking.tracker.hasPose());
  tracking.carve(sphereMasks(rig, Vec3(-0.15, 0.15, 0.1), 0.06));
  EXPECT_FALSE(tracking.follow().tracked);
}

}  // namespace
}  // namespace airclay
