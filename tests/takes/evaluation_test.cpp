// SPDX-License-Identifier: MIT
// Pose errors against closed forms: known offsets give known percentiles, a known oscillation gives a known
// jitter; ground truth is interpolated exactly where the motion is linear.
#include "capture/takes/evaluation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "capture/images/image_file.h"
#include "capture/takes/evaluation_plot.h"
#include "capture/takes/truth.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180;
const Vec3 kCenter(0.033, -0.01, 0.005);

Pose poseOf(const Vec3& rotation_vector, const Vec3& position) {
  Pose pose = Pose::Identity();
  pose.linear() = rotationFromVector(rotation_vector);
  pose.translation() = position;
  return pose;
}

/// Hands that move 4 mm and turn 0.7 degrees per frame.
EvaluatedTake movingTake(int frames) {
  EvaluatedTake take;
  for (int k = 0; k < frames; ++k) {
    EvaluatedFrame frame;
    frame.frame = 10 + k;
    frame.time_s = frame.frame / 30.0;
    frame.truth = poseOf(Vec3(0.3, 0.0122 * k, 0.2), Vec3(0.004 * k, -0.02, 0.1));
    take.push_back(frame);
  }
  return take;
}

/// The true pose turned about the hand's centre, then shifted.
Pose displaced(const Pose& truth, const Vec3& shift_m, const Vec3& turn_rad) {
  const Vec3 center = truth * kCenter;
  return Eigen::Translation3d(center + shift_m) * Pose(rotationFromVector(turn_rad)) *
         Eigen::Translation3d(-center) * truth;
}

Evaluation evaluationOf(const EvaluatedTake& take) {
  return evaluate({&take, 1}, kCenter);
}

TEST(Evaluation, CovarianceOfKnownErrorsContainsTheFractionsThatItShould) {
  // errors drawn from a known covariance whose position and rotation are correlated
  Eigen::Matrix<double, 6, 6> factor = Eigen::Matrix<double, 6, 6>::Zero();
  factor.diagonal() << 0.001, 0.002, 0.0005, 0.004, 0.002, 0.008;
  factor(4, 0) = 0.003;
  factor(5, 2) = -0.002;
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  EvaluatedTake take = movingTake(4000);
  for (EvaluatedFrame& frame : take) {
    Eigen::Matrix<double, 6, 1> error;
    for (double& value : error) value = normal(random);
    error = factor * error;
    frame.estimate = displaced(frame.truth, error.head<3>(), error.tail<3>());
    frame.covariance = factor * factor.transpose();
  }
  const Evaluation right = evaluationOf(take);
  EXPECT_NEAR(right.inside_68.value(), 0.68, 0.025);
  EXPECT_NEAR(right.inside_95.value(), 0.95, 0.012);
  // half the standard deviations: the chi-squared distribution with 6 degrees of freedom at a quarter
  for (EvaluatedFrame& frame : take) *frame.covariance /= 4;
  const Evaluation narrow = evaluationOf(take);
  EXPECT_NEAR(narrow.inside_68.value(), 0.0589, 0.012);
  EXPECT_NEAR(narrow.inside_95.value(), 0.2099, 0.02);
  for (EvaluatedFrame& frame : take) frame.covariance.reset();
  EXPECT_FALSE(evaluationOf(take).inside_68.has_value());
}

TEST(Evaluation, MahalanobisDistanceIsExact) {
  EvaluatedTake take = movingTake(1);
  take[0].covariance = Eigen::Matrix<double, 6, 6>::Identity();
  take[0].covariance->diagonal() << 1e-6, 4e-6, 1, 1e-4, 1, 1;
  take[0].estimate = displaced(take[0].truth, Vec3(0.002, 0.002, 0), Vec3(0.03, 0, 0));
  EXPECT_NEAR(mahalanobis(take[0], kCenter).value(), 4 + 1 + 9, 1e-6);
  take[0].estimate.reset();
  EXPECT_FALSE(mahalanobis(take[0], kCenter).has_value());
}

TEST(Evaluation, PercentilesInterpolateBetweenNeighbours) {
  const std::vector<double> values = {1, 2, 4, 8};
  EXPECT_DOUBLE_EQ(percentile(values, 0), 1);
  EXPECT_DOUBLE_EQ(percentile(values, 0.5), 3);
  EXPECT_DOUBLE_EQ(percentile(values, 0.9), 6.8);
  EXPECT_DOUBLE_EQ(percentile(values, 1), 8);
  EXPECT_DOUBLE_EQ(percentile(std::vector<double>{5}, 0.99), 5);
}

TEST(Evaluation, KnownOffsetsGiveKnownErrors) {
  EvaluatedTake take = movingTake(101);
  // 0 to 5 mm and 0 to 2 degrees, in another order than time's.
  for (std::size_t k = 0; k < take.size(); ++k) {
    const double share = double(k * 37 % 101) / 100;
    take[k].estimate = displaced(take[k].truth, 0.005 * share * Vec3(2, -1, 2) / 3,
                                 2 * kRadPerDeg * share * Vec3(0, 0.6, -0.8));
  }
  const Evaluation result = evaluationOf(take);
  EXPECT_EQ(result.frames, 101);
  EXPECT_EQ(result.tracked, 101);
  EXPECT_EQ(result.uncertain, 0);
  EXPECT_EQ(result.lost, 0);
  EXPECT_EQ(result.wrong_tracked, 0);
  ASSERT_TRUE(result.mm && result.deg);
  EXPECT_NEAR(result.mm->median, 2.5, 1e-9);
  EXPECT_NEAR(result.mm->p90, 4.5, 1e-9);
  EXPECT_NEAR(result.mm->p99, 4.95, 1e-9);
  EXPECT_NEAR(result.mm->worst, 5, 1e-9);
  EXPECT_NEAR(result.deg->median, 1, 1e-9);
  EXPECT_NEAR(result.deg->p90, 1.8, 1e-9);
  EXPECT_NEAR(result.deg->p99, 1.98, 1e-9);
  EXPECT_NEAR(result.deg->worst, 2, 1e-9);
  EXPECT_EQ(result.frames_to_find, 0);
  EXPECT_FALSE(result.jitter_mm || result.jitter_deg);  // the hand is never still
}

TEST(Evaluation, ErrorsAreInTheAxesOfTheWorld) {
  EvaluatedTake take = movingTake(1);
  take[0].estimate = displaced(take[0].truth, Vec3(0.001, -0.002, 0.003), Vec3(0.01, 0.02, -0.03));
  const std::optional<PoseError> error = poseError(take[0], kCenter);
  ASSERT_TRUE(error);
  EXPECT_LT((error->shift_mm - Vec3(1, -2, 3)).norm(), 1e-9);
  EXPECT_LT((error->turn_deg * kRadPerDeg - Vec3(0.01, 0.02, -0.03)).norm(), 1e-12);
}

TEST(Evaluation, CountsStatesAndWrongFrames) {
  EvaluatedTake take = movingTake(8);
  const auto place = [&](std::size_t k, double shift_m, bool is_uncertain) {
    take[k].estimate = displaced(take[k].truth, Vec3(0, shift_m, 0), Vec3::Zero());
    take[k].is_uncertain = is_uncertain;
  };
  // Frames 0, 1 and 5 are lost.
  place(2, 0.0101, false);
  place(3, 0.25, true);
  place(4, 0.0099, false);
  place(6, 0.001, true);
  place(7, 0.3, false);
  const Evaluation result = evaluationOf(take);
  EXPECT_EQ(result.frames, 8);
  EXPECT_EQ(result.tracked, 5);
  EXPECT_EQ(result.lost, 3);
  EXPECT_EQ(result.uncertain, 2);
  EXPECT_EQ(result.wrong_tracked, 2);
  EXPECT_EQ(result.frames_to_find, 4);
  EXPECT_NEAR(result.mm->median, 10.1, 1e-9);
  EXPECT_NEAR(result.mm->worst, 300, 1e-9);
}

TEST(Evaluation, LostTakesHaveNoErrors) {
  const Evaluation result = evaluationOf(movingTake(6));
  EXPECT_EQ(result.lost, 6);
  EXPECT_FALSE(result.mm || result.deg || result.jitter_mm || result.jitter_deg || result.frames_to_find);
}

/// The hand rests for `frames` frames; the estimate is off by a constant, and oscillates.
void addRest(EvaluatedTake& take, int frames, double amplitude_mm, double amplitude_deg) {
  EvaluatedFrame frame = take.back();
  frame.truth.pretranslate(Vec3(0.05, 0, 0));
  for (int k = 0; k < frames; ++k) {
    ++frame.frame;
    frame.time_s = frame.frame / 30.0;
    const double wave = std::sin(2 * std::numbers::pi * (k + 0.3) / 10);
    frame.estimate = displaced(frame.truth, Vec3(0.004, 0.001 * amplitude_mm * wave, 0),
                               kRadPerDeg * amplitude_deg * wave * Vec3::UnitX());
    take.push_back(frame);
  }
}

TEST(Evaluation, JitterIsThatOfTheStillHand) {
  EvaluatedTake take = movingTake(20);
  for (EvaluatedFrame& frame : take)  // large errors in motion do not count
    frame.estimate = displaced(frame.truth, Vec3(0.003 * (frame.frame % 3), 0, 0), Vec3(0.02, 0, 0));
  addRest(take, 4, 50, 5);  // too short
  addRest(take, 40, 0.6, 0.3);
  addRest(take, 20, 0.9, 0.6);
  const Evaluation result = evaluationOf(take);
  ASSERT_TRUE(result.jitter_mm && result.jitter_deg);
  // The mean square of a sine over whole periods is half its squared amplitude.
  EXPECT_NEAR(*result.jitter_mm, std::sqrt((40 * 0.36 + 20 * 0.81) / 60 / 2), 1e-9);
  EXPECT_NEAR(*result.jitter_deg, std::sqrt((40 * 0.09 + 20 * 0.36) / 60 / 2), 1e-9);
}

TEST(Evaluation, MissingFrameEndsARest) {
  EvaluatedTake take = movingTake(1);
  addRest(take, 9, 0.6, 0.3);
  EXPECT_TRUE(evaluationOf(take).jitter_mm);
  take.erase(take.begin() + 5);  // leaves runs of four frames
  EXPECT_FALSE(evaluationOf(take).jitter_mm);
}

TEST(Evaluation, SeveralTakesAreOneSample) {
  std::vector<EvaluatedTake> takes = {movingTake(3), movingTake(4)};
  for (EvaluatedTake& take : takes)
    for (EvaluatedFrame& frame : take)
      frame.estimate = displaced(frame.truth, Vec3(0.001 * double(take.size()), 0, 0), Vec3::Zero());
  takes[1].front().estimate.reset();
  const Evaluation total = evaluate(takes, kCenter);
  EXPECT_EQ(total.frames, 7);
  EXPECT_EQ(total.lost, 1);
  EXPECT_NEAR(total.mm->median, 3.5, 1e-9);
  EXPECT_EQ(total.frames_to_find, 1);
  for (EvaluatedFrame& frame : takes[0]) frame.estimate.reset();
  EXPECT_FALSE(evaluate(takes, kCenter).frames_to_find);
}

TEST(Evaluation, HandCenterIsBetweenWristAndKnuckle) {
  const Vec3 right = handCenter(builtInHand(false)), left = handCenter(builtInHand(true));
  EXPECT_GT(right.x(), 0.03);  // the wrist is the origin, x points to the fingertips
  EXPECT_LT(right.x(), 0.06);
  EXPECT_LT((left - Vec3(right.x(), -right.y(), right.z())).norm(), 1e-12);
}

TEST(Evaluation, PlotsHaveTheSameSizeForAnyErrors) {
  const TemporaryFolder folder;
  const auto sizeOf = [&](const EvaluatedTake& take) {
    drawEvaluation(folder / "plot.png", "take", take, kCenter);
    return imageSize(folder / "plot.png");
  };
  EvaluatedTake take = movingTake(12);
  const ImageSize size = sizeOf(take);  // all lost
  EXPECT_GE(size.width, 800);
  for (EvaluatedFrame& frame : take) frame.estimate = frame.truth;
  EXPECT_EQ(sizeOf(take), size);  // exact
  take[5].estimate->pretranslate(Vec3(0.4, 0, 0));
  EXPECT_EQ(sizeOf(take), size);  // logarithmic
  EXPECT_EQ(sizeOf({}), size);
}

TEST(Evaluation, PlotMarksLostFrames) {
  const TemporaryFolder folder;
  const auto reddish = [&](const EvaluatedTake& take) {
    drawEvaluation(folder / "plot.png", "take", take, kCenter);
    const ImageSize size = imageSize(folder / "plot.png");
    std::vector<std::uint8_t> bgr(std::size_t(3) * std::size_t(size.width) * std::size_t(size.height));
    readImage(folder / "plot.png", size, PixelFormat::kBgr8, bgr);
    std::size_t count = 0;
    for (std::size_t i = 0; i < bgr.size(); i += 3) count += bgr[i + 2] > bgr[i] + 25;
    return double(count) / double(bgr.size() / 3);
  };
  EvaluatedTake take = movingTake(20);
  for (EvaluatedFrame& frame : take) frame.estimate = displaced(frame.truth, Vec3(0.001, 0, 0), Vec3::Zero());
  EXPECT_EQ(reddish(take), 0);
  take[7].estimate.reset();
  const double one = reddish(take);
  EXPECT_GT(one, 0.01);
  take[12].estimate.reset();
  EXPECT_NEAR(reddish(take), 2 * one, 0.1 * one);
}

// ------------------------------------------------------------------------------------------------- truth

const Pose kStart = poseOf(Vec3(0.2, -0.1, 0.4), Vec3(0.1, 0, -0.1));
const Vec3 kVelocity(0.5, -0.3, 0.2), kTurnRate(0.7, 1.1, -2.0);

/// A motion with constant velocity and turn rate, on which interpolation is exact.
Pose motionAt(double time_s) {
  Pose pose = kStart;
  pose.linear() = rotationFromVector(time_s * kTurnRate) * kStart.linear();
  pose.translation() += time_s * kVelocity;
  return pose;
}

std::vector<TimedPose> motion(double from_s, double to_s, double rate_hz) {
  std::vector<TimedPose> poses;
  for (double k = std::round(from_s * rate_hz); k <= to_s * rate_hz + 1e-6; ++k)
    poses.push_back({k / rate_hz, motionAt(k / rate_hz)});
  return poses;
}

TEST(Truth, DenseMotionIsInterpolated) {
  const Truth truth{motion(0.5, 1, 30), motion(0.45, 0.8, 300)};
  for (const double time_s : {0.5, 0.5012, 0.613, 0.79999}) {
    const std::optional<Pose> pose = truth.at(time_s, 1.0 / 30);
    ASSERT_TRUE(pose) << time_s;
    EXPECT_LT((pose->translation() - motionAt(time_s).translation()).norm(), 1e-12) << time_s;
    EXPECT_LT(angleBetween(pose->linear(), motionAt(time_s).linear()), 1e-9) << time_s;
  }
  // After the dense motion, the nearest pose of truth.tum.
  EXPECT_TRUE(truth.at(0.91, 1.0 / 30)->isApprox(motionAt(0.9), 1e-12));
  // A frame without a pose in truth.tum does not count, although the dense motion covers it.
  EXPECT_FALSE(truth.at(0.48, 1.0 / 30));
  EXPECT_FALSE(truth.at(1.02, 1.0 / 30));
}

TEST(Truth, GapsAreNotInterpolated) {
  std::vector<TimedPose> dense = motion(0, 1, 300);
  std::erase_if(dense, [](const TimedPose& pose) { return pose.time_s > 0.4 && pose.time_s < 0.6; });
  EXPECT_TRUE(interpolatedPose(dense, 0.301, 1.0 / 30));
  EXPECT_FALSE(interpolatedPose(dense, 0.5, 1.0 / 30));
  EXPECT_FALSE(interpolatedPose(dense, -0.001, 1.0 / 30));
  EXPECT_FALSE(interpolatedPose(dense, 1.001, 1.0 / 30));
  EXPECT_FALSE(interpolatedPose({}, 0, 1));
}

TEST(Truth, ErrorsNameFileAndLine) {
  const TemporaryFolder folder;
  const std::string path = folder.path().string();
  EXPECT_NE(messageOf([&] { readTruth(folder / "none"); }).find("no such take"), std::string::npos);
  EXPECT_EQ(messageOf([&] { readTruth(folder.path()); }).find(path + ": "), 0u);
  folder.write("truth.tum", "0.1 0 0 0 0 0 0 1\n0.2 0 0 0 0 0 1\n");
  EXPECT_EQ(messageOf([&] { readTruth(folder.path()); }).find(path + "/truth.tum:2: "), 0u);
  folder.write("truth.tum", "0.1 0 0 0 0 0 0 1\n");
  EXPECT_TRUE(readTruth(folder.path()).dense.empty());
  folder.write("truth_dense.tum", "0.1 0 0 0 0 0 0 2\n");
  EXPECT_EQ(messageOf([&] { readTruth(folder.path()); }).find(path + "/truth_dense.tum:1: "), 0u);
}

}  // namespace
}  // namespace airclay
