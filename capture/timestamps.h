// SPDX-License-Identifier: MIT
// When the frames of a recording were taken: timestamps.csv, Caliscope's form.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace airclay {

/// The time of each frame in seconds, the mean of its cameras' times. The file has a header that names cam_id
/// and frame_time, then a row a frame a camera; cam_id is a camera's name, or the number that its name ends
/// in, or, where no name ends in a number, its place in the rig. Rows past `frame_count` are not used. \throw
/// Error naming file and line: another header, a row that is malformed, an unknown camera, times that don't
/// grow; or a camera with too few rows.
std::vector<double> readFrameTimes(const std::filesystem::path& file,
                                   const std::vector<std::string>& camera_names, int frame_count);

}  // namespace airclay
