// SPDX-License-Identifier: MIT
// Detects plain chessboards: OpenCV finds the grid of corners, saddle_point.h refines each corner.
#pragma once

#include <optional>

#include "capture/calibration/board.h"
#include "capture/calibration/saddle_point.h"

namespace airclay {

/// All inner corners of a chessboard, numbered as in board.h. Empty if a corner is missing or the image shows
/// a different board. \pre board.chessboard
std::optional<BoardView> findChessboard(const Board& board, const GreyImage& image);

}  // namespace airclay
