// SPDX-License-Identifier: MIT
// Camera names and the file names of their videos.
#pragma once

#include <array>
#include <string>

namespace airclay {

/// The extensions of a take's videos, in lower case; files may use any case.
inline constexpr std::array kVideoExtensions{".mp4", ".mkv", ".avi", ".mov", ".webm", ".m4v", ".mts"};

/// Whether a file name has a video's extension, in any case.
bool isVideoName(const std::string& file);

/// The camera that a rig's `name` denotes: a video's path without folders and extension, any other name
/// unchanged.
std::string cameraNameOf(const std::string& name);

}  // namespace airclay
