// SPDX-License-Identifier: MIT
// Writes images to an H.264 video that any player supports.
#pragma once

#include <memory>

#include "capture/images/image_file.h"

namespace airclay {

/// Writes FILE.mp4: H.264, yuv420p. finish() creates the file atomically; without it, no file remains.
class VideoWriter {
 public:
  /// The pixel format, rows from the top without padding; the value is the bytes per pixel.
  enum class Format { kBgr8 = 3, kRgba8 = 4 };

  struct Options {
    ImageSize size;  ///< 16 to 16384 per side, even because yuv420p halves it
    double rate_hz = 30;
    Format format = Format::kRgba8;
  };

  /// \throw Error naming the file if it is not an .mp4, its folder cannot be written, or a side is odd.
  VideoWriter(const std::filesystem::path& file, const Options& options);
  ~VideoWriter();
  VideoWriter(VideoWriter&&) noexcept;
  VideoWriter& operator=(VideoWriter&&) noexcept;

  void write(std::span<const std::uint8_t> pixels);
  /// Closes the video and renames it to its final name. \throw Error if frames are missing, because the disk
  /// is full.
  void finish();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace airclay
