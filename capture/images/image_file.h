// SPDX-License-Identifier: MIT
// Image files: reads PNG and JPEG, writes PNG.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

namespace airclay {

struct ImageSize {
  int width = 0, height = 0;  ///< pixels
  bool operator==(const ImageSize&) const = default;
};

/// The format of decoded pixels, without padding; the value is the bytes per pixel.
enum class PixelFormat { kGrey8 = 1, kBgr8 = 3 };

/// An image's size, from its header. \throw Error naming the file if it is not a PNG or JPEG, or is
/// incomplete.
ImageSize imageSize(const std::filesystem::path& file);

/// Decodes an image and ignores its orientation tag, because calibrations refer to the raw image. \pre
/// `pixels` has width * height * bytes per pixel. \throw Error naming the file if it has another size, is not
/// a PNG or JPEG, or is damaged.
void readImage(const std::filesystem::path& file, ImageSize size, PixelFormat format,
               std::span<std::uint8_t> pixels);

/// Writes RGBA pixels, 8 bits per channel, rows from the top, atomically.
void writePng(const std::filesystem::path& file, ImageSize size, std::span<const std::uint8_t> rgba);

}  // namespace airclay
