// SPDX-License-Identifier: MIT
// Where in a camera's image a board has been seen.
#pragma once

#include <string>
#include <vector>

#include "capture/images/image_file.h"
#include "engine/core/math.h"

namespace airclay {

/// The cells of an image, an eighth of its width across and square, in which a corner was seen.
class BoardCoverage {
 public:
  static constexpr int kColumns = 8;

  /// \pre size is that of an image
  explicit BoardCoverage(ImageSize size);

  void add(const Vec2& pixel);
  int rows() const { return rows_; }
  double cellPixels() const { return cell_px_; }
  bool covered(int column, int row) const {
    return cells_[static_cast<std::size_t>(row * kColumns + column)];
  }
  double share() const;
  /// The sides of the image, two cells deep, of which less than a third is covered: "left, top".
  std::string emptySides() const;

 private:
  int countIn(int x, int y, int width, int height) const;

  double cell_px_;
  int rows_;
  std::vector<char> cells_;
};

}  // namespace airclay
