// SPDX-License-Identifier: MIT
// What a video file states about its frames, read from its packets without decoding any image.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace airclay {

struct VideoIndex {
  /// When each frame is presented, in seconds after the first one, strictly increasing. Empty if the
  /// container does not state a time for every frame.
  std::vector<double> times_s;
  int frames = 0;            ///< packets of the video stream that are to be shown
  int rotation_degrees = 0;  ///< clockwise, by which players turn the image: 0, 90, 180 or 270
  int bits = 8;              ///< per component
  bool is_mono = false;      ///< one component
  std::string pixel_format;  ///< FFmpeg's name: yuv420p, gray10le
};

/// \throw Error naming the file if it is not a video.
VideoIndex readVideoIndex(const std::filesystem::path& file);

/// How many frames are missing: gaps of more than one and a half median intervals, in whole intervals.
int missingFrames(const std::vector<double>& times_s);

/// The median interval between times, or 0 with fewer than two. \pre ascending
double medianInterval(const std::vector<double>& times_s);

}  // namespace airclay
