// SPDX-License-Identifier: MIT
// Clock offsets estimated from known motion.
#include "capture/cameras/clock_offsets.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/scene.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

/// A hand that moves freely in the workspace, seen by cameras with individual clocks.
struct Motion {
  double seconds = 20, noise_px = 0.3, bias_m = 0;
  bool along_a_line = false;
  unsigned seed = 1;
  Rig rig = ringRig(4, 640, 480);

  Vec3 at(double time_s) const {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> phase(0, 2 * M_PI), rate(0.2, 1.3);
    Vec3 point = Vec3::Zero();
    for (int i = 0; i < 6; ++i) {
      const double hz = rate(random);
      Vec3 wave;
      for (int axis = 0; axis < 3; ++axis)
        wave[axis] = 0.05 / std::sqrt(hz) * std::sin(2 * M_PI * hz * time_s + phase(random));
      point += along_a_line ? Vec3(wave.x() * Vec3(0.6, 0.7, 0.3)) : wave;
    }
    return point;
  }
  /// `bias_m`: each camera sees the hand's centre displaced, and the displacement changes as the hand
  /// rotates.
  Vec3 centreFor(std::size_t camera, double time_s) const {
    const double turn = 2 * M_PI * 0.21 * time_s + 2.3 * double(camera);
    return at(time_s) + bias_m * Vec3(std::sin(turn), std::cos(1.3 * turn), std::sin(0.7 * turn));
  }
  std::vector<MotionSeries> seen(const std::vector<double>& offsets_s) const {
    std::mt19937 random(seed + 100);
    std::normal_distribution<double> noise(0, noise_px);
    std::vector<MotionSeries> all(offsets_s.size());
    for (std::size_t c = 0; c < offsets_s.size(); ++c)
      for (int k = 0; k < seconds * 30; ++k) {
        const double time_s = (k + 0.23 * double(c)) / 30;  // shutters are not synchronized either
        const auto pixel = project(rig.cameras[c], centreFor(c, time_s));
        if (!pixel) continue;
        all[c].times_s.push_back(time_s + offsets_s[c]);
        all[c].centroid_px.push_back(*pixel + Vec2(noise(random), noise(random)));
      }
    return all;
  }
  /// The worst error, seconds.
  double worst(const std::vector<double>& truth_s) const {
    const ClockOffsets found = estimateClockOffsets(rig, seen(truth_s));
    double worst_s = 0;
    for (std::size_t c = 0; c < truth_s.size(); ++c)
      worst_s = std::max(worst_s, std::abs(found.offset_s[c] - truth_s[c]));
    return worst_s;
  }
};

const std::vector<double> kOffsetsS = {0, 0.0123, -0.041, 0.0875};

TEST(ClockOffsets, EstimatedFromFreeMotion) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Motion motion;
    motion.seed = seed;
    EXPECT_LT(motion.worst(kOffsetsS), 0.001) << seed;
    const ClockOffsets found = estimateClockOffsets(motion.rig, motion.seen(kOffsetsS));
    for (const double deviation_s : found.deviation_s) EXPECT_LT(deviation_s, 0.001) << seed;
  }
}

TEST(ClockOffsets, EstimatedFromLinearMotionAndByTwoCameras) {
  Motion line;
  line.along_a_line = true;
  EXPECT_LT(line.worst({0, 0.03, -0.1, 0.2}), 0.002);
  Motion two;
  two.rig.cameras.resize(2);
  EXPECT_LT(two.worst({0, 0.03}), 0.002);
}

TEST(ClockOffsets, TolerateInexactCentresAndAMovedCamera) {
  Motion motion;
  motion.bias_m = 0.01;
  EXPECT_LT(motion.worst(kOffsetsS), 0.005);
  Motion bumped;
  const std::vector<MotionSeries> seen = bumped.seen(kOffsetsS);
  Pose& pose = bumped.rig.cameras[2].camera_from_world;
  pose.linear() = rotationFromVector(Vec3(0.004, -0.004, 0.003)) * pose.linear();  // a third of a degree
  const ClockOffsets found = estimateClockOffsets(bumped.rig, seen);
  for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(found.offset_s[c], kOffsetsS[c], 0.003);
}

TEST(ClockOffsets, RejectUnobservableOffsets) {
  const auto refusal = [](const Motion& motion) {
    return messageOf([&] { estimateClockOffsets(motion.rig, motion.seen(kOffsetsS)); });
  };
  Motion brief;
  brief.seconds = 2;
  EXPECT_NE(refusal(brief).find("too short"), std::string::npos);
  EXPECT_NE(refusal(brief).find("cam0"), std::string::npos);

  // nothing moves: only noise
  std::vector<MotionSeries> still(4);
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 1);
  for (MotionSeries& series : still)
    for (int k = 0; k < 900; ++k) {
      series.times_s.push_back(k / 30.0);
      series.centroid_px.push_back(Vec2(320 + noise(random), 240 + noise(random)));
    }
  const Rig rig = ringRig(4, 640, 480);
  EXPECT_NE(messageOf([&] { estimateClockOffsets(rig, still); }).find("same motion"), std::string::npos);

  // a pendulum of 4 Hz looks the same after a quarter of a second
  std::vector<MotionSeries> pendulum(4);
  for (std::size_t c = 0; c < 4; ++c)
    for (int k = 0; k < 300; ++k) {
      const double swing = 0.1 * std::sin(2 * M_PI * 4 * k / 30.0);
      pendulum[c].times_s.push_back(k / 30.0);
      pendulum[c].centroid_px.push_back(*project(rig.cameras[c], swing * Vec3(0.6, 0.7, 0.3)));
    }
  EXPECT_NE(messageOf([&] { estimateClockOffsets(rig, pendulum); }).find("periodic"), std::string::npos);
}

}  // namespace
}  // namespace airclay
