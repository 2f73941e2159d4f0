// SPDX-License-Identifier: MIT
// A sheet on which pictures are laid side by side.
#pragma once

#include "app/session/images.h"

namespace airclay {

/// Pictures with rounded corners on a light sheet.
class Page {
 public:
  static constexpr int kMargin = 24, kGap = 16;  ///< pixels

  explicit Page(PictureSize size);
  /// The picture's upper left corner comes to (left, top). What reaches over the sheet's edge is cut off.
  void lay(const Picture& picture, int left, int top);
  const Picture& picture() const { return picture_; }

 private:
  Picture picture_;
};

/// Reduced to `size` by averaging, in linear light. \pre size is no larger than the picture's
Picture reduced(const Picture& picture, PictureSize size);

}  // namespace airclay
