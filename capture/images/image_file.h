// SPDX-License-Identifier: MIT
// Image files: reads PNG, JPEG, BMP, TIFF and WebP, writes PNG.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

namespace airclay {

struct ImageSize {
  int width = 0, height = 0;  ///< pixels
  bool operator==(const ImageSize&) const = default;
};

/// The format of decoded pixels, without padding; the value is the bytes per pixel.
enum class PixelFormat { kGrey8 = 1, kBgr8 = 3 };

/// Whether the file's extension is that of an image, in any case: .png, .jpg, .jpeg, .bmp, .tif, .tiff,
/// .webp.
bool isImageName(const std::string& file);

/// An image's size, from its header. \throw Error naming the file if it is not an image of these formats, or
/// is incomplete.
ImageSize imageSize(const std::filesystem::path& file);

/// The significant bits of the samples: 8, or in a 16-bit image 10, 12, 14 or 16, the fewest that hold its
/// largest value. \throw Error as imageSize
int imageBits(const std::filesystem::path& file);

/// Decodes an image and ignores its orientation tag, because calibrations refer to the raw image. Grey images
/// become BGR with equal channels. Samples of `bits` bits are scaled by 255 / (2^bits - 1), rounded and
/// limited to 255; without `bits`, those of imageBits(). Pass the bits of a camera's first image to scale all
/// of its images alike. \pre `pixels` has width * height * bytes per pixel. \throw Error naming the file if
/// it has another size, is not an image of these formats, or is damaged.
void readImage(const std::filesystem::path& file, ImageSize size, PixelFormat format,
               std::span<std::uint8_t> pixels, std::optional<int> bits = std::nullopt);

/// Writes RGBA pixels, 8 bits per channel, rows from the top, atomically.
void writePng(const std::filesystem::path& file, ImageSize size, std::span<const std::uint8_t> rgba);

}  // namespace airclay
