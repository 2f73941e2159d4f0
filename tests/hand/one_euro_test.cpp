// SPDX-License-Identifier: MIT
// The One Euro filter on signals with a closed-form response: with T_e between samples and the time
// constant tau, alpha = 1 / (1 + tau / T_e); the response to a step is 1 - (1 - alpha)^n, and a ramp of slope
// v is followed v tau behind, at any sampling rate. The cutoff at speed v is f + beta v^2 / (v + tremor).
#include "engine/hand/one_euro.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace airclay {
namespace {

constexpr double kDegree = M_PI / 180;

double timeConstant(double cutoff_hz) {
  return 1 / (2 * M_PI * cutoff_hz);
}

Pose at(const Vec3& position, const Mat3& turn = Mat3::Identity()) {
  Pose pose = Pose::Identity();
  pose.translation() = position;
  pose.linear() = turn;
  return pose;
}

double cutoff(const OneEuroOptions& options, double speed_m_s) {
  return options.rest_cutoff_hz +
         options.cutoff_hz_per_m_s * speed_m_s * speed_m_s / (speed_m_s + options.tremor_m_s);
}
double turnCutoff(const OneEuroOptions& options, double speed_rad_s) {
  return options.rotation_rest_cutoff_hz + options.rotation_cutoff_hz_per_rad_s * speed_rad_s * speed_rad_s /
                                               (speed_rad_s + options.tremor_rad_s);
}

/// The same cutoff at any speed.
OneEuroOptions fixedCutoff(double hz) {
  OneEuroOptions options;
  options.rest_cutoff_hz = options.rotation_rest_cutoff_hz = hz;
  options.cutoff_hz_per_m_s = options.rotation_cutoff_hz_per_rad_s = 0;
  return options;
}

/// Times between 1 and 100 ms apart.
std::vector<double> unevenTimes(int count) {
  std::mt19937 random(7);
  std::vector<double> times;
  double time_s = 3;
  for (int i = 0; i < count; ++i)
    times.push_back(time_s += std::uniform_real_distribution<>(0.001, 0.1)(random));
  return times;
}

TEST(OneEuro, FirstSampleIsUnchanged) {
  OneEuroPose filter;
  const Pose pose = at({0.1, 0.2, 0.3}, rotationFromVector({0.5, 1, -2}));
  EXPECT_EQ(filter.latencyS(), 0);
  EXPECT_TRUE(filter.filter(5, pose).isApprox(pose, 1e-12));
  EXPECT_EQ(filter.latencyS(), 0);
}

TEST(OneEuro, StepResponseIsAPower) {
  OneEuroPose filter(fixedCutoff(2));
  const double step_s = 1.0 / 30, alpha = 1 / (1 + timeConstant(2) / step_s);
  const Vec3 jump_m(0.01, -0.02, 0.03), turn(0.2, -0.4, 0.1);
  filter.filter(0, at(Vec3::Zero()));
  for (int i = 1; i < 60; ++i) {
    const Pose smooth = filter.filter(i * step_s, at(jump_m, rotationFromVector(turn)));
    const double answer = 1 - std::pow(1 - alpha, i);
    EXPECT_LT((smooth.translation() - answer * jump_m).norm(), 1e-14);
    EXPECT_LT(angleBetween(smooth.linear(), rotationFromVector(answer * turn)), 1e-7);
  }
}

TEST(OneEuro, RampLagsByTheStatedLatency) {
  for (const double speed_m_s : {0.003, 0.02, 0.1, 0.3, 1.0}) {
    const OneEuroOptions options;
    const double lag_s = timeConstant(cutoff(options, speed_m_s));
    const Vec3 velocity_m_s = speed_m_s * Vec3(1, 2, -2) / 3;
    OneEuroPose filter;
    Pose smooth = Pose::Identity();
    double last_s = 0;
    for (const double time_s : unevenTimes(400)) {
      smooth = filter.filter(time_s, at(time_s * velocity_m_s));
      last_s = time_s;
    }
    EXPECT_LT((smooth.translation() - (last_s - lag_s) * velocity_m_s).norm(), 1e-9) << speed_m_s;
    EXPECT_NEAR(filter.latencyS(), lag_s, 1e-9) << speed_m_s;
    EXPECT_LT(lag_s * speed_m_s, 0.0009) << "metres behind";
    EXPECT_TRUE(speed_m_s < 0.3 || lag_s < 0.0015);
    EXPECT_NEAR(filter.speedMetresS(), speed_m_s, 1e-3 * speed_m_s);
  }
}

TEST(OneEuro, FollowsManyRevolutions) {
  const OneEuroOptions options;
  const Vec3 axis = Vec3(3, -1, 2).normalized();
  for (const double speed_rad_s : {-4.0, 1.0, 6.0}) {  // the quaternion changes sign at each revolution
    const double lag_s = timeConstant(turnCutoff(options, std::abs(speed_rad_s)));
    OneEuroPose filter;
    for (const double time_s : unevenTimes(600)) {
      const auto turned = [&](double to_s) { return rotationFromVector(speed_rad_s * to_s * axis); };
      const Pose smooth = filter.filter(time_s, at(Vec3::Zero(), turned(time_s)));
      if (time_s < 15) continue;  // settled after twelve seconds
      EXPECT_LT(angleBetween(smooth.linear(), turned(time_s - lag_s)), 1e-6);
      EXPECT_NEAR(filter.rotationLatencyS(), lag_s, 1e-8);
    }
  }
}

TEST(OneEuro, StillHandDoesNotJitter) {
  std::mt19937 random(3);
  std::normal_distribution<> normal;
  const auto noise = [&](double sigma) {
    const double x = normal(random), y = normal(random), z = normal(random);
    return Vec3(sigma * x, sigma * y, sigma * z);
  };
  const Mat3 turn = rotationFromVector({2, 1, 0.5});
  OneEuroPose filter;
  double moved_m2 = 0, turned_2 = 0;
  int count = 0;
  for (int i = 0; i < 3000; ++i) {
    const Pose smooth = filter.filter(
        i / 30.0, at(Vec3(0.1, 0, 0.2) + noise(0.33e-3), turn * rotationFromVector(noise(0.3 * kDegree))));
    if (i < 90) continue;
    moved_m2 += (smooth.translation() - Vec3(0.1, 0, 0.2)).squaredNorm() / 3;  // per axis
    turned_2 += std::pow(angleBetween(smooth.linear(), turn), 2) / 3;
    ++count;
  }
  EXPECT_LT(std::sqrt(moved_m2 / count), 0.1e-3);
  EXPECT_LT(std::sqrt(turned_2 / count), 0.1 * kDegree);
  EXPECT_GT(std::sqrt(moved_m2 / count), 1e-6);  // it follows
}

TEST(OneEuro, IsRotationInvariant) {
  // Filtering commutes with rotations of the world.
  const Pose turned = at({0.3, -0.1, 0.7}, rotationFromVector({1, -2, 0.5}));
  OneEuroPose here, there;
  for (const double time_s : unevenTimes(200)) {
    const Pose pose = at(0.1 * Vec3(std::sin(3 * time_s), std::cos(5 * time_s), std::sin(7 * time_s)),
                         rotationFromVector({std::sin(2 * time_s), 0.5, std::cos(3 * time_s)}));
    const Pose smooth = here.filter(time_s, pose);
    EXPECT_TRUE(there.filter(time_s, turned * pose).isApprox(turned * smooth, 1e-9));
  }
}

TEST(OneEuro, IgnoresNonIncreasingTime) {
  OneEuroPose filter;
  for (int i = 0; i < 30; ++i) filter.filter(100 + i / 30.0, at({0.01 * i, 0, 0}));
  const double last_s = 100 + 29 / 30.0, latency_s = filter.latencyS();
  const Pose before = filter.filter(last_s, at({0.29, 0, 0}));
  for (const double time_s : {last_s, last_s - 0.01, 2.0, 2.0}) {
    const Pose smooth = filter.filter(time_s, at({5, 5, 5}, rotationFromVector({1, 1, 1})));
    EXPECT_TRUE(smooth.isApprox(before, 0));
    EXPECT_EQ(filter.latencyS(), latency_s);
  }
  // A clock that is set back does not stop it.
  Pose smooth = Pose::Identity();
  for (int i = 1; i < 300; ++i) smooth = filter.filter(2 + i / 30.0, at({0.5, 0, 0}));
  EXPECT_LT((smooth.translation() - Vec3(0.5, 0, 0)).norm(), 1e-4);
}

TEST(OneEuro, TinyTimeStepDoesNotAmplifyNoise) {
  // Half a millimetre within a nanosecond: 500 km/s, once.
  OneEuroPose filter;
  for (int i = 0; i < 60; ++i) filter.filter(i / 30.0, at(Vec3::Zero()));
  const double rest_lag_s = filter.latencyS();
  const Pose smooth = filter.filter(59 / 30.0 + 1e-9, at({0.0005, 0, 0}));
  EXPECT_LT(smooth.translation().norm(), 1e-6);
  EXPECT_GT(filter.latencyS(), 0.3 * rest_lag_s);
}

TEST(OneEuro, ResetDiscardsTheState) {
  OneEuroPose filter;
  for (int i = 0; i < 30; ++i) filter.filter(i / 30.0, at({0.01 * i, 0, 0}));
  filter.reset();
  EXPECT_EQ(filter.latencyS(), 0);
  const Pose elsewhere = at({-0.2, 0.1, 0}, rotationFromVector({0, 3, 0}));
  EXPECT_TRUE(filter.filter(1.5, elsewhere).isApprox(elsewhere, 1e-12));
  EXPECT_TRUE(filter.filter(1.6, elsewhere).isApprox(elsewhere, 1e-12));
  EXPECT_LE(filter.latencyS(), 0.1 + 1e-12);  // at most the time since its first sample
}

}  // namespace
}  // namespace airclay
