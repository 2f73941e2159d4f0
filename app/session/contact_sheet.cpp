// SPDX-License-Identifier: MIT
#include "app/session/contact_sheet.h"

#include <algorithm>
#include <cmath>

namespace airclay {
namespace {

constexpr int kSheet[3] = {250, 249, 247};
constexpr double kCornerRadius = 10;  // pixels

/// The fraction of a pixel inside a rectangle with rounded corners.
double cover(ImageSize size, int x, int y) {
  const double across = std::abs(x + 0.5 - 0.5 * size.width) - (0.5 * size.width - kCornerRadius);
  const double down = std::abs(y + 0.5 - 0.5 * size.height) - (0.5 * size.height - kCornerRadius);
  const double outside = std::hypot(std::max(across, 0.0), std::max(down, 0.0)) - kCornerRadius;
  return std::clamp(0.5 - outside, 0.0, 1.0);
}

}  // namespace

ContactSheet::ContactSheet(ImageSize size) {
  image_.size = size;
  image_.rgba.resize(std::size_t(4) * std::size_t(size.width) * std::size_t(size.height), 255);
  for (std::size_t i = 0; i < image_.rgba.size(); ++i)
    if (i % 4 < 3) image_.rgba[i] = static_cast<std::uint8_t>(kSheet[i % 4]);
}

void ContactSheet::lay(const RgbaImage& image, int left, int top) {
  for (int y = 0; y < image.size.height; ++y)
    for (int x = 0; x < image.size.width; ++x) {
      if (x + left < 0 || y + top < 0 || x + left >= image_.size.width || y + top >= image_.size.height)
        continue;
      const double share = cover(image.size, x, y);
      const std::size_t from = 4 * (std::size_t(y) * std::size_t(image.size.width) + std::size_t(x));
      const std::size_t to =
          4 * (std::size_t(y + top) * std::size_t(image_.size.width) + std::size_t(x + left));
      for (std::size_t c = 0; c < 3; ++c)
        image_.rgba[to + c] = static_cast<std::uint8_t>(
            std::lround(share * image.rgba[from + c] + (1 - share) * image_.rgba[to + c]));
    }
}

RgbaImage reduced(const RgbaImage& image, ImageSize size) {
  RgbaImage result{size, {}};
  result.rgba.resize(std::size_t(4) * std::size_t(size.width) * std::size_t(size.height), 255);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const int x0 = x * image.size.width / size.width, x1 = (x + 1) * image.size.width / size.width;
      const int y0 = y * image.size.height / size.height, y1 = (y + 1) * image.size.height / size.height;
      for (int c = 0; c < 3; ++c) {
        double sum = 0;
        for (int v = y0; v < y1; ++v)
          for (int u = x0; u < x1; ++u)
            sum += std::pow(image.rgba[std::size_t(4 * (v * image.size.width + u) + c)] / 255.0, 2.2);
        const double mean = sum / ((x1 - x0) * (y1 - y0));
        result.rgba[std::size_t(4 * (y * size.width + x) + c)] =
            static_cast<std::uint8_t>(std::lround(255 * std::pow(mean, 1 / 2.2)));
      }
    }
  return result;
}

}  // namespace airclay
