// SPDX-License-Identifier: MIT
// A sheet on which images are laid side by side.
#pragma once

#include "app/session/images.h"

namespace airclay {

/// Images with rounded corners on a light sheet.
class ContactSheet {
 public:
  static constexpr int kMargin = 24, kGap = 16;  ///< pixels

  explicit ContactSheet(ImageSize size);
  /// The image's upper left corner comes to (left, top). What reaches over the sheet's edge is cut off.
  void lay(const RgbaImage& image, int left, int top);
  const RgbaImage& image() const { return image_; }

 private:
  RgbaImage image_;
};

/// Reduced to `size` by averaging, in linear light. \pre size is no larger than the image's
RgbaImage reduced(const RgbaImage& image, ImageSize size);

}  // namespace airclay
