// SPDX-License-Identifier: MIT
// Hand poses in the trajectory format of the TUM RGB-D benchmark (Sturm et al. 2012), which tools such as evo
// read.
#pragma once

#include <filesystem>

#include "engine/core/math.h"

namespace airclay {

struct TimedPose {
  double time_s = 0;
  Pose world_from_hand = Pose::Identity();
};

/// Reads lines of `timestamp tx ty tz qx qy qz qw`; seconds, metres; `#` starts a comment. \throw Error
/// naming file and line if a line is malformed, a number is not finite, a quaternion's length is off by more
/// than 1e-3, times do not increase, or there is no pose.
std::vector<TimedPose> readPoses(const std::filesystem::path& file);

/// Writes the same format with qw >= 0, atomically.
void writePoses(const std::filesystem::path& file, const std::vector<TimedPose>& poses);

}  // namespace airclay
