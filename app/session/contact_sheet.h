// SPDX-License-Identifier: MIT
// A sheet with images side by side.
#pragma once

#include "app/session/images.h"

namespace airclay {

/// Images with rounded corners on a light sheet.
class ContactSheet {
 public:
  static constexpr int kMargin = 24, kGap = 16;  ///< pixels

  explicit ContactSheet(ImageSize size);
  /// Places the image's upper left corner at (left, top) and crops it at the sheet's edges.
  void lay(const RgbaImage& image, int left, int top);
  const RgbaImage& image() const { return image_; }

 private:
  RgbaImage image_;
};

/// Reduced to `size` by averaging, in linear light. \pre size is no larger than the image's
RgbaImage reduced(const RgbaImage& image, ImageSize size);

}  // namespace airclay
