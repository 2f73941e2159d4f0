// SPDX-License-Identifier: MIT
#include "capture/takes/evaluation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace airclay {
namespace {

constexpr double kDegPerRad = 180 / std::numbers::pi;
// Quantiles of the chi-squared distribution with 6 degrees of freedom.
constexpr double kQuantile68 = 7.006, kQuantile95 = 12.592;

double fractionBelow(const std::vector<double>& values, double limit) {
  return static_cast<double>(std::ranges::count_if(values, [&](double value) { return value < limit; })) /
         static_cast<double>(values.size());
}

PoseError difference(const Pose& a, const Pose& b, const Vec3& center_in_hand) {
  const Eigen::AngleAxisd turn(Eigen::Quaterniond(a.linear() * b.linear().transpose()));
  return {1000 * (a * center_in_hand - b * center_in_hand), kDegPerRad * turn.angle() * turn.axis()};
}

ErrorDistribution distributionOf(std::vector<double> errors) {
  std::sort(errors.begin(), errors.end());
  return {percentile(errors, 0.5), percentile(errors, 0.9), percentile(errors, 0.99), errors.back()};
}

/// Collects the squared deviations of vectors from the mean of their run.
class Jitter {
 public:
  void addRun(const std::vector<Vec3>& errors) {
    Vec3 mean = Vec3::Zero();
    for (const Vec3& error : errors) mean += error / static_cast<double>(errors.size());
    for (const Vec3& error : errors) squares_ += (error - mean).squaredNorm();
    count_ += errors.size();
  }
  std::optional<double> rms() const {
    if (count_ == 0) return std::nullopt;
    return std::sqrt(squares_ / static_cast<double>(count_));
  }

 private:
  double squares_ = 0;
  std::size_t count_ = 0;
};

bool isStill(const EvaluatedFrame& before, const EvaluatedFrame& after, const Vec3& center_in_hand) {
  const PoseError motion = difference(after.truth, before.truth, center_in_hand);
  return after.frame == before.frame + 1 && motion.mm() < kStillMm && motion.deg() < kStillDeg;
}

/// Splits a take into the longest runs of frames in which the true hand is still.
std::vector<std::span<const EvaluatedFrame>> stillRuns(const EvaluatedTake& take,
                                                       const Vec3& center_in_hand) {
  std::vector<std::span<const EvaluatedFrame>> runs;
  std::size_t first = 0;
  for (std::size_t i = 1; i <= take.size(); ++i) {
    if (i < take.size() && isStill(take[i - 1], take[i], center_in_hand)) continue;
    if (i - first >= kStillFrames) runs.push_back(std::span(take).subspan(first, i - first));
    first = i;
  }
  return runs;
}

std::optional<int> framesToFind(const EvaluatedTake& take, const Vec3& center_in_hand) {
  for (const EvaluatedFrame& frame : take)
    if (const std::optional<PoseError> error = poseError(frame, center_in_hand);
        error && error->mm() <= kWrongMm)
      return frame.frame - take.front().frame;
  return std::nullopt;
}

}  // namespace

Vec3 handCenter(const HandModel& hand) {
  const auto position = [&](const std::string& name) -> Vec3 {
    const auto joint = std::ranges::find(hand.joints, name, &Joint::name);
    if (joint == hand.joints.end()) throw std::logic_error("the hand model has no joint " + name);
    return joint->hand_from_joint_rest.translation();
  };
  return 0.5 * (position("wrist") + position("middle-finger-phalanx-proximal"));
}

std::optional<PoseError> poseError(const EvaluatedFrame& frame, const Vec3& center_in_hand) {
  if (!frame.estimate) return std::nullopt;
  return difference(*frame.estimate, frame.truth, center_in_hand);
}

std::optional<double> mahalanobis(const EvaluatedFrame& frame, const Vec3& center_in_hand) {
  const std::optional<PoseError> error = poseError(frame, center_in_hand);
  if (!error || !frame.covariance) return std::nullopt;
  Eigen::Matrix<double, 6, 1> both;
  both << error->shift_mm / 1000, error->turn_deg / kDegPerRad;
  return both.dot(frame.covariance->ldlt().solve(both));
}

double percentile(std::span<const double> sorted, double p) {
  const double place = p * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(sorted[below], sorted[above], place - static_cast<double>(below));
}

Evaluation evaluate(std::span<const EvaluatedTake> takes, const Vec3& center_in_hand) {
  Evaluation result;
  std::vector<double> mm, deg, distances;
  Jitter shift_mm, turn_deg;
  for (const EvaluatedTake& take : takes) {
    for (const EvaluatedFrame& frame : take) {
      ++result.frames;
      const std::optional<PoseError> error = poseError(frame, center_in_hand);
      if (!error) {
        ++result.lost;
        continue;
      }
      ++result.tracked;
      if (frame.is_uncertain)
        ++result.uncertain;
      else if (error->mm() > kWrongMm)
        ++result.wrong_tracked;
      if (const std::optional<double> distance = mahalanobis(frame, center_in_hand);
          distance && !frame.is_uncertain)
        distances.push_back(*distance);
      mm.push_back(error->mm());
      deg.push_back(error->deg());
    }
    for (const std::span<const EvaluatedFrame> run : stillRuns(take, center_in_hand)) {
      std::vector<Vec3> shifts_mm, turns_deg;
      for (const EvaluatedFrame& frame : run)
        if (const std::optional<PoseError> error = poseError(frame, center_in_hand)) {
          shifts_mm.push_back(error->shift_mm);
          turns_deg.push_back(error->turn_deg);
        }
      if (shifts_mm.size() < kStillFrames) continue;
      shift_mm.addRun(shifts_mm);
      turn_deg.addRun(turns_deg);
    }
  }
  if (!mm.empty()) result.mm = distributionOf(mm), result.deg = distributionOf(deg);
  if (!distances.empty()) {
    result.inside_68 = fractionBelow(distances, kQuantile68);
    result.inside_95 = fractionBelow(distances, kQuantile95);
  }
  result.jitter_mm = shift_mm.rms(), result.jitter_deg = turn_deg.rms();
  result.frames_to_find = takes.empty() ? std::nullopt : std::optional(0);
  for (const EvaluatedTake& take : takes) {
    const std::optional<int> found = framesToFind(take, center_in_hand);
    if (!found) {
      result.frames_to_find.reset();
      break;
    }
    result.frames_to_find = std::max(*result.frames_to_find, *found);
  }
  return result;
}

}  // namespace airclay
