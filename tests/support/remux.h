// SPDX-License-Identifier: MIT
// Copies a video's packets to another file, with frames left out or rotation metadata added.
#pragma once

#include <filesystem>
#include <functional>

namespace airclay {

struct RemuxOptions {
  std::function<bool(int)> keep = [](int) { return true; };  ///< of frame k; the others keep their times
  std::function<double(int)> time_s;                         ///< of frame k; empty: unchanged
  int rotation_degrees = 0;                                  ///< clockwise, for the player
};

/// Throws std::runtime_error if a file cannot be read or written.
void remuxVideo(const std::filesystem::path& from, const std::filesystem::path& to,
                const RemuxOptions& options);

}  // namespace airclay
