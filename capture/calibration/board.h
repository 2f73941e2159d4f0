// SPDX-License-Identifier: MIT
// Calibration boards: ChArUco boards of OpenCV's dictionaries, and plain chessboards.
//
// Board frame, in metres: the origin is the board's upper left corner, x points right along a row of squares,
// y down, and z into the board (right-handed). Squares and inner corners are numbered row by row from the
// upper left; a corner's id is its number. The upper left square is black, as in OpenCV since 4.6.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/core/math.h"

namespace airclay {

/// The layout of a board. Valid if checkBoard() accepts it.
struct Board {
  int squares_x = 5, squares_y = 3;   ///< per row and per column
  double square_m = 0.054;            ///< edge of a square, as measured on the print
  double marker_m = 0.040;            ///< edge of a marker
  std::string dictionary = "4X4_50";  ///< OpenCV's name without DICT_
  bool inverted = false;              ///< white and black are swapped
  bool chessboard = false;            ///< no markers: the detector finds all inner corners or none
  /// The back shows the mirrored board, each corner behind its counterpart, so the board is also detected
  /// from behind.
  bool two_sided = false;

  int cornersX() const { return squares_x - 1; }
  int cornersY() const { return squares_y - 1; }
  int cornerCount() const { return cornersX() * cornersY(); }
  double widthM() const { return squares_x * square_m; }
  double heightM() const { return squares_y * square_m; }
  /// Whether the squares to the upper left and lower right of a corner are black (on a board that is not
  /// inverted).
  bool blackBefore(int id) const { return (id % cornersX() + id / cornersX()) % 2 == 0; }
  /// The position of a corner in the board frame, metres. \pre 0 <= id < cornerCount()
  Vec3 corner(int id) const { return square_m * Vec3(id % cornersX() + 1, id / cornersX() + 1, 0); }

  /// Whether the board looks the same after half a turn: a chessboard whose numbers of squares are both even
  /// or both odd. The corners of such a board are numbered so that its rows point right in the image.
  bool isAmbiguous() const { return chessboard && (squares_x + squares_y) % 2 == 0; }
};

/// The sharpness and brightness of a board in an image: medians over its corners.
struct BoardExposure {
  double black = 0, white = 0;  ///< grey values of the squares, 0 to 255
  double blur_px = 0;  ///< standard deviation of the blur across edges, including the pixel's own area
};

/// The inner corners of a board that one image shows, in the raw, distorted image. Pixel centres have integer
/// coordinates; the positions are unbiased to a few hundredths of a pixel.
struct BoardView {
  std::vector<int> ids;                   ///< ascending
  std::vector<Vec2> pixels;               ///< one per id
  std::optional<BoardExposure> exposure;  ///< empty if the view does not come from an image
};

/// The maximum number of squares per row and column; more are probably a typing error.
inline constexpr int kMaxSquares = 40;

/// Checks a board's layout. \throw Error (Fault::kUsage) naming the option and the expected value if a row or
/// column has fewer than 3 squares (chessboard: 4) or more than kMaxSquares, a size is not in (0, 2] m, a
/// marker is as large as its square, or the dictionary is unknown or has too few markers.
void checkBoard(const Board& board);

/// "5 x 3 squares of 54 mm, markers of 40 mm, 4X4_50".
std::string describe(const Board& board);
/// A length for display, in millimetres with at most two decimals: "54", "53.85".
std::string inMillimetres(double length_m);

}  // namespace airclay
