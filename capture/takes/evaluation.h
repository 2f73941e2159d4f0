// SPDX-License-Identifier: MIT
// Errors of tracked poses against the ground truth.
//
// Positions are compared at the hand's centre, the middle between wrist and middle finger's knuckle: at the
// origin of the hand frame, which may be anywhere, a rotation error would count as a position error.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "engine/core/math.h"
#include "engine/hand/hand_model.h"

namespace airclay {

/// A pose farther from the truth is wrong: about half a finger's width.
inline constexpr double kWrongMm = 10;

/// A frame with ground truth, and what tracking found in it.
struct EvaluatedFrame {
  int frame = 0;  ///< number in the take
  double time_s = 0;
  std::optional<Pose> estimate;   ///< world_from_hand; empty: lost
  bool is_uncertain = false;      ///< the estimate is reported as not reliable
  Pose truth = Pose::Identity();  ///< world_from_hand
  /// The estimate's: of the hand's centre in metres and a rotation vector in radians, world axes. Empty: the
  /// fit gives none.
  std::optional<Eigen::Matrix<double, 6, 6>> covariance;
};

/// The error of one estimate, in the world's axes.
struct PoseError {
  Vec3 shift_mm;  ///< of the hand's centre, estimate - truth
  Vec3 turn_deg;  ///< rotation vector of R_estimate R_truthᵀ
  double mm() const { return shift_mm.norm(); }
  double deg() const { return turn_deg.norm(); }
};

/// The middle between the joints wrist and middle-finger-phalanx-proximal in the rest pose, hand frame.
Vec3 handCenter(const HandModel& hand);

/// Empty if the hand is lost.
std::optional<PoseError> poseError(const EvaluatedFrame& frame, const Vec3& center_in_hand);

/// The squared Mahalanobis distance of the estimate from the truth by its covariance, about 6 in the mean if
/// the covariance is right. Empty if the hand is lost or the fit gives no covariance.
std::optional<double> mahalanobis(const EvaluatedFrame& frame, const Vec3& center_in_hand);

/// Value below which the fraction `p` of the values is, interpolated linearly between neighbours. \pre the
/// values are sorted, at least one, and 0 <= p <= 1
double percentile(std::span<const double> sorted, double p);

struct ErrorDistribution {
  double median = 0, p90 = 0, p99 = 0, worst = 0;
};

struct Evaluation {
  int frames = 0;     ///< with ground truth: tracked + lost
  int tracked = 0;    ///< with a pose
  int uncertain = 0;  ///< of those tracked
  int lost = 0;
  int wrong_tracked = 0;                     ///< tracked, not uncertain, and more than kWrongMm off
  std::optional<ErrorDistribution> mm, deg;  ///< over all frames with a pose; empty if there is none
  /// RMS of the error's deviation from its mean while the true hand is still (kStillMm, kStillDeg), over all
  /// such runs of at least kStillFrames frames; empty if there is none.
  std::optional<double> jitter_mm, jitter_deg;
  /// From the first frame with truth to the first pose within kWrongMm, 0 if that is the first frame; empty
  /// if there is none. Of several takes, the largest.
  std::optional<int> frames_to_find;
  /// Fraction of the errors inside the ellipsoids that should contain 68 % and 95 % of them, over all poses
  /// that are not uncertain; empty if none has a covariance.
  std::optional<double> inside_68, inside_95;
};

/// The true hand is still if it moves less than this between two frames.
inline constexpr double kStillMm = 0.2, kStillDeg = 0.1;
inline constexpr int kStillFrames = 5;

/// The frames of one take, in their order.
using EvaluatedTake = std::vector<EvaluatedFrame>;

/// Statistics of one or several takes.
Evaluation evaluate(std::span<const EvaluatedTake> takes, const Vec3& center_in_hand);

}  // namespace airclay
