// SPDX-License-Identifier: MIT
// Plain chessboards: OpenCV finds the grid of corners, each is then fitted (saddle_point.h).
#pragma once

#include <optional>

#include "capture/calibration/board.h"
#include "capture/calibration/saddle_point.h"

namespace airclay {

/// All inner corners of a chessboard, in the order in which it lies; none where one is missing, or another
/// board is there. \pre board.chessboard
std::optional<BoardView> findChessboard(const Board& board, const GreyImage& image);

}  // namespace airclay
