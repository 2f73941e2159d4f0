// SPDX-License-Identifier: MIT
// One camera's recorded frames: a video, or a folder of numbered images.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "capture/images/image_file.h"

namespace airclay {

/// Frames by number, cheapest in order.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  virtual ImageSize size() const = 0;
  virtual int frameCount() const = 0;
  virtual double rateHz() const = 0;
  /// Decodes a frame into width * height * 3 bytes. \pre 0 <= frame < frameCount()
  /// \throw Error naming the file and the frame when it cannot be decoded.
  virtual void read(int frame, std::span<std::uint8_t> bgr) = 0;
};

/// The frames of camera `name` in a take's folder: NAME.mp4 or another of kVideoExtensions, else the images
/// in NAME/. Endings and names of videos may be in capitals. None when there are neither. \throw Error naming
/// the file when it cannot be opened, has no frame, or numbers have a gap; when there are two videos; or the
/// video is shorter than it declares, unless it may be `unfinished`.
std::unique_ptr<FrameSource> openFrames(const std::filesystem::path& take, const std::string& name,
                                        bool unfinished = false);

/// The images in a folder by the number that is their name: 000000.png, 1.jpg. Other files are not looked
/// at. \throw Error naming two files of one number, or a number past a million.
std::map<int, std::filesystem::path> numberedImages(const std::filesystem::path& folder);

}  // namespace airclay
