// SPDX-License-Identifier: MIT
// Still images in files: PNG and JPEG in, PNG out.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

namespace airclay {

struct ImageSize {
  int width = 0, height = 0;  ///< pixels
  bool operator==(const ImageSize&) const = default;
};

/// How the pixels are wanted, tightly packed.
enum class PixelFormat { kGrey8 = 1, kBgr8 = 3 };

/// An image's size, from its header alone. \throw Error naming the file when it is no PNG or JPEG, or is
/// incomplete.
ImageSize imageSize(const std::filesystem::path& file);

/// Decodes an image as it lies in the file (an orientation tag is not applied: a calibration is of the raw
/// image). \pre pixels holds width * height * bytes of the form. \throw Error naming the file when it is of
/// another size, no PNG or JPEG, or broken.
void readImage(const std::filesystem::path& file, ImageSize size, PixelFormat form,
               std::span<std::uint8_t> pixels);

/// Writes RGBA pixels, 8 bits a channel, rows from the top. The file appears whole or not at all.
void writePng(const std::filesystem::path& file, ImageSize size, std::span<const std::uint8_t> rgba);

}  // namespace airclay
