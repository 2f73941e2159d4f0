// SPDX-License-Identifier: MIT
// A camera's name and the name of its video.
#pragma once

#include <array>
#include <string>

namespace airclay {

/// The endings of videos that a take may hold, in small letters; a file may write them in capitals.
inline constexpr std::array kVideoEndings{".mp4", ".mkv", ".avi", ".mov", ".webm", ".m4v", ".mts"};

/// Whether a file's name ends like a video's, in small letters or capitals.
bool isVideoName(const std::string& file);

/// The camera that a rig means by `name`: without the folders and the ending of its video.
std::string cameraNameOf(const std::string& name);

}  // namespace airclay
