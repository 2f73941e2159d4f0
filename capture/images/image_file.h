// SPDX-License-Identifier: MIT
// Still pictures in files: PNG and JPEG in, PNG out.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

namespace airclay {

struct PictureSize {
  int width = 0, height = 0;  ///< pixels
  bool operator==(const PictureSize&) const = default;
};

/// How the pixels are wanted, tightly packed.
enum class PixelForm { kGrey8 = 1, kBgr8 = 3 };

/// A picture's size, from its header alone. \throw Error naming the file when it is no PNG or JPEG, or is
/// incomplete.
PictureSize pictureSize(const std::filesystem::path& file);

/// Decodes a picture as it lies in the file (an orientation tag is not applied: a calibration is of the raw
/// picture). \pre pixels holds width * height * bytes of the form. \throw Error naming the file when it is of
/// another size, no PNG or JPEG, or broken.
void readPicture(const std::filesystem::path& file, PictureSize size, PixelForm form,
                 std::span<std::uint8_t> pixels);

/// Writes RGBA pixels, 8 bits a channel, rows from the top. The file appears whole or not at all.
void writePng(const std::filesystem::path& file, PictureSize size, std::span<const std::uint8_t> rgba);

}  // namespace airclay
