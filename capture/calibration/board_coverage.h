// SPDX-License-Identifier: MIT
// The parts of a camera's image in which a board has been seen.
#pragma once

#include <string>
#include <vector>

#include "capture/images/image_file.h"
#include "engine/core/math.h"

namespace airclay {

/// A grid of square cells, each an eighth of the image's width, that marks where corners were seen.
class BoardCoverage {
 public:
  static constexpr int kColumns = 8;

  /// \pre size is positive
  explicit BoardCoverage(ImageSize size);

  void add(const Vec2& pixel);
  int rows() const { return rows_; }
  double cellPixels() const { return cell_px_; }
  bool covered(int column, int row) const {
    return cells_[static_cast<std::size_t>(row * kColumns + column)];
  }
  /// The fraction of covered cells.
  double fraction() const;
  /// The sides of the image, two cells wide, that are less than a third covered: "left, top".
  std::string emptySides() const;

 private:
  int countIn(int x, int y, int width, int height) const;

  double cell_px_;
  int rows_;
  std::vector<char> cells_;
};

}  // namespace airclay
