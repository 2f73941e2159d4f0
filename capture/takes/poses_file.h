// SPDX-License-Identifier: MIT
// Hand poses in files: the TUM RGB-D benchmark's trajectory form (Sturm et al. 2012), read by evo and its
// like.
#pragma once

#include <filesystem>

#include "engine/core/math.h"

namespace airclay {

struct TimedPose {
  double time_s = 0;
  Pose world_from_hand = Pose::Identity();
};

/// Reads lines of `timestamp tx ty tz qx qy qz qw`; seconds, metres; `#` starts a comment. \throw Error
/// naming file and line: a line of another form, a number that is not finite, a quaternion off unit length by
/// more than 1e-3, times that don't grow, or no pose at all.
std::vector<TimedPose> readPoses(const std::filesystem::path& file);

/// Writes them so, qw >= 0. The file appears whole or not at all.
void writePoses(const std::filesystem::path& file, const std::vector<TimedPose>& poses);

}  // namespace airclay
