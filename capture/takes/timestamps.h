// SPDX-License-Identifier: MIT
// The capture times of a recording's frames: timestamps.csv, in Caliscope's format.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace airclay {

/// The times of each frame, seconds, one per camera in the order of the names. The file has a header with the
/// columns cam_id and frame_time, then one row per frame and camera. cam_id is a camera's name, the number at
/// its end, or, if no name ends in a number, its index in the rig. Rows beyond `frame_count` are ignored.
/// \throw Error naming file and line if the header is wrong, a row is malformed, a camera is unknown, or
/// times do not increase; or if a camera has too few rows. If `unfinished`, the file may be truncated: an
/// incomplete last line is ignored, and there are as many frames as every camera has rows.
std::vector<std::vector<double>> readFrameTimes(const std::filesystem::path& file,
                                                const std::vector<std::string>& camera_names, int frame_count,
                                                bool unfinished = false);

}  // namespace airclay
