// SPDX-License-Identifier: MIT
// Estimates the offsets between the cameras' clocks from a moving hand.
//
// The same motion looks different from each side: a motion that is fast for one camera may be straight
// towards another, which sees no motion. So neither speeds nor pauses can be compared (in our experiments,
// speeds as signals, and even their best linear combinations, missed a known offset by up to 12 ms). With a
// rig, rays can be compared: at one instant, the rays of all cameras through the hand's centre intersect (the
// epipolar constraint, Hartley and Zisserman, Multiple View Geometry, 9). With a wrong offset, the distance
// between the rays of two cameras varies as the hand moves; the correct offset minimizes this variance. It
// minimizes the variance rather than the distance because the silhouettes' centroids are not exactly one
// point, and a rig has small errors.
#pragma once

#include <string>
#include <vector>

#include "engine/camera/rig.h"

namespace airclay {

/// The motion seen by one camera, on its own clock. Frames without the hand are omitted.
struct MotionSeries {
  std::vector<double> times_s;    ///< increasing
  std::vector<Vec2> centroid_px;  ///< of the silhouette, in the raw, distorted image; one per time
};

struct ClockOffsets {
  /// The lag of each camera's times relative to the first camera's, to be subtracted. The first is 0.
  std::vector<double> offset_s;
  /// Standard errors: the deviation of estimates from thirds of the recording, divided by √3.
  std::vector<double> deviation_s;
};

struct ClockOffsetOptions {
  double max_offset_s = 0.5;  ///< the largest offset between two clocks
};

/// Combines all pairs of cameras by weighted least squares. `cameras`: one series per camera, in the rig's
/// order. \throw Error naming a camera whose offset cannot be determined: it saw the hand for less than 3 s,
/// the hand did not move, or the motion is periodic so that several offsets fit.
ClockOffsets estimateClockOffsets(const Rig& rig, const std::vector<MotionSeries>& cameras,
                                  const ClockOffsetOptions& options = {});

}  // namespace airclay
