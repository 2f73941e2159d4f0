// SPDX-License-Identifier: MIT
// One camera's recorded frames: a video or a folder of numbered images.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/images/image_file.h"

namespace airclay {

/// Frames by number; fastest in ascending order.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  virtual ImageSize size() const = 0;
  virtual int frameCount() const = 0;
  virtual double rateHz() const = 0;
  /// When each frame was taken, in seconds after the first one: a video's presentation timestamps. Empty if
  /// unknown.
  virtual const std::vector<double>& timesS() const = 0;
  /// "yuv420p, 8 bits": how the file stores pixels; empty if unknown.
  virtual std::string pixelFormat() const { return {}; }
  /// Decodes a frame into width * height * 3 bytes. \pre 0 <= frame < frameCount()
  /// \throw Error naming the file and the frame if it cannot be decoded.
  virtual void read(int frame, std::span<std::uint8_t> bgr) = 0;
};

/// The frames of camera `name` in a take's folder: NAME.mp4 or another of kVideoExtensions, otherwise the
/// images in NAME/. Video names and extensions match in any case. Null if there are neither. \throw Error
/// naming the file if it cannot be opened, has no frame, or image numbers have a gap; if there are two
/// videos; or if the video is shorter than it declares and not `unfinished`.
std::unique_ptr<FrameSource> openFrames(const std::filesystem::path& take, const std::string& name,
                                        bool unfinished = false);

/// The images in a folder by the number in their name: 000000.png, 1.jpg. Ignores other files. \throw Error
/// for two files with the same number, or a number above a million.
std::map<int, std::filesystem::path> numberedImages(const std::filesystem::path& folder);

}  // namespace airclay
