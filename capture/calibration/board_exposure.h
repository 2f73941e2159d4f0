// SPDX-License-Identifier: MIT
// How sharp and how well lit a board stands in an image.
#pragma once

#include <optional>
#include <span>

#include "capture/calibration/board.h"
#include "capture/images/image_file.h"

namespace airclay {

struct BoardExposure {
  double black = 0, white = 0;  ///< grey values of 255 on both sides of the squares' edges, medians
  /// Standard deviation of the blur across these edges in pixels, the gathering by a pixel's own square
  /// included; what is larger than a fifth of a marker's margin is seen too small.
  double blur_px = 0;
};

/// Measured at the squares' edges between neighbouring corners of a view. \pre bgr: 3 bytes a pixel, rows
/// from the top. None when no two neighbours are there, or no contrast.
std::optional<BoardExposure> boardExposure(const Board& board, const BoardView& view, ImageSize size,
                                           std::span<const std::uint8_t> bgr);

}  // namespace airclay
