// SPDX-License-Identifier: MIT
// Whether cameras will be able to read a board, and which one they would.
#pragma once

#include <optional>
#include <span>

#include "capture/calibration/board_image.h"

namespace airclay {

/// How large things look to a camera: at distance_m before it, facing it, in the middle of its image.
struct BoardSight {
  double focal_px = 0;
  double distance_m = 0;
};

/// The focal length of an image `width` pixels wide with a horizontal field of view, in pixels.
double focalOf(int width, double fov_degrees);

/// How many pixels a marker's cell has, from edge to edge; of a chessboard, which has none, a square.
double cellPixels(const Board& board, const BoardSight& sight);

/// What cellPixels() must be at least: 3 for a cell (at 2, on boards held aslant, one marker of four is no
/// longer read in drawn images, and real ones are worse); 10 for a square.
double leastCellPixels(const Board& board);

/// The side of a marker (of a chessboard: of a square) in pixels, along the direction that the board's tilt
/// shortens less; the median over all views. Empty without two neighbouring corners.
std::optional<double> markerPixels(const Board& board, std::span<const BoardView* const> views);

/// What markerPixels() must be at least: leastCellPixels() times the cells of a marker.
double leastMarkerPixels(const Board& board);

/// "the board is too small in the image: ...", with the measured and the required size; empty if its markers
/// have 0.83 of leastMarkerPixels() or more, which suffices for sharp images.
std::string describeSmallBoard(const Board& board, double marker_px);

struct BoardProposal {
  Board board;
  Page page = Page::kA4;
  double cell_px = 0;
};

/// A board that the camera reads: of those that A4 or A3 hold (A3 where `page` is A3; A4 before A3 else), the
/// one of most squares. None where even the largest squares are too small.
std::optional<BoardProposal> readableBoard(const Board& requested, const BoardSight& sight, Page page);

/// A marker's edge that leaves enough white around it: 0.74 of the square's, in whole millimetres, or tenths
/// under 10 mm.
double usualMarker(double square_m);

}  // namespace airclay
