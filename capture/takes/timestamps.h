// SPDX-License-Identifier: MIT
// When the frames of a recording were taken: timestamps.csv, Caliscope's form.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace airclay {

/// The times of each frame in seconds, one a camera in the order of the names. The file has a header that
/// names cam_id and frame_time, then a row a frame a camera; cam_id is a camera's name, or the number that
/// its name ends in, or, where no name ends in a number, its place in the rig. Rows past `frame_count` are
/// not used. \throw Error naming file and line: another header, a row that is malformed, an unknown camera,
/// times that don't grow; or a camera with too few rows. Where `unfinished`, the file may have been cut off
/// while it was written: a last line without its end is not looked at, and the frames are as many as every
/// camera has rows.
std::vector<std::vector<double>> readFrameTimes(const std::filesystem::path& file,
                                                const std::vector<std::string>& camera_names, int frame_count,
                                                bool unfinished = false);

}  // namespace airclay
