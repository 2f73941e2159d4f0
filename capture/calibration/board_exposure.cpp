// SPDX-License-Identifier: MIT
#include "capture/calibration/board_exposure.h"

#include <cmath>

#include "engine/core/median.h"

namespace airclay {

BoardExposure exposureOf(std::span<const SaddlePoint> corners) {
  constexpr double kPixelVariance = 1.0 / 12;  // of a uniform distribution over one pixel
  std::vector<double> black, white, blur;
  for (const SaddlePoint& corner : corners) {
    black.push_back(corner.mean - corner.contrast / 2);
    white.push_back(corner.mean + corner.contrast / 2);
    blur.push_back(std::sqrt(corner.blur_px * corner.blur_px + kPixelVariance));
  }
  return {median(black), median(white), median(blur)};
}

}  // namespace airclay
