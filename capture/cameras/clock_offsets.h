// SPDX-License-Identifier: MIT
// How far the cameras' clocks are apart, told from what they saw: a hand that moves.
//
// The same motion looks different from each side: as fast as it is for one camera, another may see it come
// straight at it and stand still. So neither speeds nor their pauses can be compared (speeds as signals, and
// even their best linear combinations, missed a known offset by up to 12 ms in our trials). What can be with
// a rig: at one instant, the rays through the hand's centre meet, from all sides (the epipolar constraint,
// Hartley and Zisserman, Multiple View Geometry, 9). With a wrong offset the rays of two cameras pass each
// other at a distance that changes as the hand moves; the offset with the steadiest distance is the right
// one. Steadiest, not least: the silhouettes' centres are not quite one point, and a rig is not quite true.
#pragma once

#include <string>
#include <vector>

#include "engine/camera/rig.h"

namespace airclay {

/// What one camera saw of the motion, on its own clock. Frames without the hand are left out.
struct MotionSeries {
  std::vector<double> times_s;    ///< growing
  std::vector<Vec2> centroid_px;  ///< of the silhouette, in the raw, distorted image; one a time
};

struct ClockOffsets {
  /// What each camera's times are too late by, beside the first one's; to be subtracted. The first is 0.
  std::vector<double> offset_s;
  /// How sure each is: the scatter of the same estimate from thirds of the recording, over the root of 3.
  std::vector<double> deviation_s;
};

struct ClockOffsetOptions {
  double max_offset_s = 0.5;  ///< farther apart no two clocks are
};

/// All pairs of cameras, put together by least squares, the surer pairs counting more. One series a camera,
/// in the rig's order. \throw Error naming the camera whose clock cannot be told: it saw the hand for less
/// than 3 s, the hand did not move, or its motion repeats so that several offsets fit.
ClockOffsets estimateClockOffsets(const Rig& rig, const std::vector<MotionSeries>& cameras,
                                  const ClockOffsetOptions& options = {});

}  // namespace airclay
