// SPDX-License-Identifier: MIT
// Images into an H.264 video that any player shows.
#pragma once

#include <memory>

#include "capture/images/image_file.h"

namespace airclay {

/// Writes FILE.mp4: H.264, yuv420p. The file appears whole when finish() returns; without it, nothing is
/// left.
class VideoWriter {
 public:
  /// Bytes of a pixel, tightly packed, rows from the top.
  enum class Format { kBgr8 = 3, kRgba8 = 4 };

  struct Options {
    ImageSize size;  ///< even, 16 to 16384 a side: yuv420p halves it
    double rate_hz = 30;
    Format format = Format::kRgba8;
  };

  /// \throw Error naming the file when its folder cannot be written, or when it is no .mp4, or the size is
  /// odd.
  VideoWriter(const std::filesystem::path& file, const Options& options);
  ~VideoWriter();
  VideoWriter(VideoWriter&&) noexcept;
  VideoWriter& operator=(VideoWriter&&) noexcept;

  void write(std::span<const std::uint8_t> pixels);
  /// Closes the video and gives it its name. \throw Error when it does not hold every frame: the disk is
  /// full.
  void finish();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace airclay
