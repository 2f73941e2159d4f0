// SPDX-License-Identifier: MIT
// The pictures of several cameras beside and below each other in a window, as large as they fit, a label's
// room below each.
#pragma once

#include <vector>

#include "app/studio/window.h"
#include "capture/camera_source.h"

namespace airclay {

/// Where a camera's picture lies in the window, pixels.
struct PicturePlace {
  int left = 0, top = 0, width = 0, height = 0;
  double scale = 1;  ///< window's pixels a picture's

  int right() const { return left + width; }
  int bottom() const { return top + height; }
};

class CameraGrid {
 public:
  explicit CameraGrid(Gpu& gpu) : gpu_(gpu) {}

  /// Places pictures of these sizes in the window's left upper `width` x `height` pixels, in as many columns
  /// as let them be largest. \param em the letters' height, pixels
  void place(const std::vector<PictureSize>& sizes, double width, double height, double em);
  /// Draws the pictures, one a place; grey where one is missing. \pre what was drawn before has been shown
  void draw(const std::vector<LivePicture>& pictures);

  const std::vector<PicturePlace>& places() const { return places_; }
  const std::vector<Inset>& insets() const { return insets_; }

  /// Of the label below a picture, in letters' heights.
  static constexpr double kLabelHeight = 3.4;

 private:
  Gpu& gpu_;
  std::vector<PicturePlace> places_;
  Buffer<std::uint32_t> pixels_;
  std::vector<Inset> insets_;
};

}  // namespace airclay
