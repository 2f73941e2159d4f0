// SPDX-License-Identifier: MIT
#include "capture/calibration/board_coverage.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace airclay {

BoardCoverage::BoardCoverage(ImageSize size)
    : cell_px_(static_cast<double>(size.width) / kColumns),
      rows_(static_cast<int>(std::ceil(size.height / cell_px_))),
      cells_(static_cast<std::size_t>(rows_ * kColumns), 0) {}

void BoardCoverage::add(const Vec2& pixel) {
  const int x = std::clamp(static_cast<int>((pixel.x() + 0.5) / cell_px_), 0, kColumns - 1);
  const int y = std::clamp(static_cast<int>((pixel.y() + 0.5) / cell_px_), 0, rows_ - 1);
  cells_[static_cast<std::size_t>(y * kColumns + x)] = 1;
}

double BoardCoverage::fraction() const {
  return static_cast<double>(std::count(cells_.begin(), cells_.end(), 1)) /
         static_cast<double>(cells_.size());
}

std::string BoardCoverage::emptySides() const {
  const std::array<int, 4> counts = {countIn(0, 0, 2, rows_), countIn(kColumns - 2, 0, 2, rows_),
                                     countIn(0, 0, kColumns, 2), countIn(0, rows_ - 2, kColumns, 2)};
  const std::array<int, 4> sizes = {2 * rows_, 2 * rows_, 2 * kColumns, 2 * kColumns};
  const char* const names[] = {"left", "right", "top", "bottom"};
  std::string sides;
  for (std::size_t i = 0; i < 4; ++i)
    if (3 * counts[i] < sizes[i]) sides += (sides.empty() ? "" : ", ") + std::string(names[i]);
  return sides;
}

int BoardCoverage::countIn(int x, int y, int width, int height) const {
  int count = 0;
  for (int v = std::max(y, 0); v < std::min(y + height, rows_); ++v)
    for (int u = x; u < x + width; ++u) count += covered(u, v);
  return count;
}

}  // namespace airclay
