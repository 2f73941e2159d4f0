// SPDX-License-Identifier: MIT
// Predicts whether a camera can read a board, and proposes one that it can.
#pragma once

#include <optional>
#include <span>

#include "capture/calibration/board_image.h"

namespace airclay {

/// A board at the centre of a camera's image, facing the camera.
struct BoardSight {
  double focal_px = 0;
  double distance_m = 0;  ///< from the camera to the board
};

/// The focal length, in pixels, of a camera with images `width` pixels wide and this horizontal field of
/// view.
double focalOf(int width, double fov_degrees);

/// The size of a marker's cell in the image, in pixels; on a chessboard, the size of a square.
double cellPixels(const Board& board, const BoardSight& sight);

/// The minimum of cellPixels(): 3 for a cell, 10 for a square. With cells of 2 pixels, one marker in four
/// cannot be read in synthetic images of tilted boards, and real images are worse.
double minCellPixels(const Board& board);

/// The side of a marker (on a chessboard: of a square) in the image, in pixels: along the board axis that its
/// tilt shortens less; the median over all views. Empty if no view has two neighbouring corners.
std::optional<double> markerPixels(const Board& board, std::span<const BoardView* const> views);

/// The minimum of markerPixels(): minCellPixels() times the cells along a marker's side.
double minMarkerPixels(const Board& board);

/// "the board is too small in the image: ...", with the measured and the required size. Empty if `marker_px`
/// is at least 0.83 minMarkerPixels(), which suffices for sharp images.
std::string describeSmallBoard(const Board& board, double marker_px);

struct BoardProposal {
  Board board;
  Page page = Page::kA4;
  double cell_px = 0;  ///< cellPixels() of the board
};

/// A board that the camera can read, with as many squares as possible. It fits A4 if such a board exists and
/// `page` is not A3, otherwise A3. Empty if even the largest squares are too small.
std::optional<BoardProposal> readableBoard(const Board& requested, const BoardSight& sight, Page page);

/// The edge of a marker that leaves a sufficient white margin in its square, in metres: 0.74 of the square's
/// edge, rounded to millimetres; to tenths of a millimetre below 10 mm.
double defaultMarker(double square_m);

}  // namespace airclay
