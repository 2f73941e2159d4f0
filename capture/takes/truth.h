// SPDX-License-Identifier: MIT
// The true motion of the hand in a take, known for rendered or measured takes.
#pragma once

#include <optional>

#include "capture/takes/poses_file.h"

namespace airclay {

/// The pose nearest in time, not farther than half of `frame_s`.
std::optional<Pose> nearestPose(const std::vector<TimedPose>& poses, double time_s, double frame_s);

/// The pose between its neighbours in time: positions linearly, rotations by slerp. Empty outside the poses,
/// and between neighbours more than `gap_s` apart.
std::optional<Pose> interpolatedPose(const std::vector<TimedPose>& poses, double time_s, double gap_s);

struct Truth {
  std::vector<TimedPose> frames;  ///< truth.tum: one pose per frame in which the hand is present
  std::vector<TimedPose> dense;   ///< truth_dense.tum: the same motion at a higher rate; may be empty

  /// The true pose in a frame; empty if truth.tum has none within half a frame. Interpolated from the dense
  /// motion if that covers `time_s`, otherwise the nearest pose of truth.tum.
  std::optional<Pose> at(double time_s, double frame_s) const;
};

/// Reads truth.tum and, if present, truth_dense.tum. \throw Error if the folder or its truth.tum does not
/// exist, or naming file and line as readPoses() does.
Truth readTruth(const std::filesystem::path& take);

}  // namespace airclay
