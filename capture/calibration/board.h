// SPDX-License-Identifier: MIT
// Calibration boards: ChArUco boards of OpenCV's dictionaries, and plain chessboards.
//
// Board frame: origin at the board's corner, x along its rows of squares to the right, y down, z into the
// board (x, y, z right-handed); metres. Squares are counted row by row from the upper left; the inner corners
// too, and a corner's number is its id. The square in the upper left is black, as OpenCV draws it since 4.6.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/core/math.h"

namespace airclay {

/// What a board is. \see checkBoard
struct Board {
  int squares_x = 5, squares_y = 3;   ///< along its width and its height
  double square_m = 0.054;            ///< a square's edge: measured on the print, not as ordered
  double marker_m = 0.040;            ///< a marker's edge
  std::string dictionary = "4X4_50";  ///< OpenCV's name without DICT_
  bool inverted = false;              ///< white and black are exchanged
  bool chessboard = false;            ///< plain: no markers, all inner corners or none are found
  /// Its back bears the same board mirrored, each corner behind its twin: from behind it is found, too.
  bool two_sided = false;

  int cornersX() const { return squares_x - 1; }
  int cornersY() const { return squares_y - 1; }
  int cornerCount() const { return cornersX() * cornersY(); }
  double widthM() const { return squares_x * square_m; }
  double heightM() const { return squares_y * square_m; }
  /// Whether the squares to the upper left and the lower right of a corner are the black ones, of a board
  /// that is not inverted.
  bool blackBefore(int id) const { return (id % cornersX() + id / cornersX()) % 2 == 0; }
  /// \pre 0 <= id < cornerCount()
  Vec3 corner(int id) const { return square_m * Vec3(id % cornersX() + 1, id / cornersX() + 1, 0); }

  /// Looks the same when turned by half a turn: a plain chessboard whose numbers of squares are both even or
  /// both odd. In each image its corners are counted so that its rows run to the right.
  bool isAmbiguous() const { return chessboard && (squares_x + squares_y) % 2 == 0; }
};

/// How sharp and how well lit a board is in an image: medians over its corners.
struct BoardExposure {
  double black = 0, white = 0;  ///< grey values of 255 of the squares
  double blur_px = 0;  ///< standard deviation of the blur across edges, including the pixel's own square
};

/// The inner corners of a board that one image shows, each where it is in the raw, distorted image: pixel
/// centres at whole numbers, unbiased to a few hundredths of a pixel.
struct BoardView {
  std::vector<int> ids;                   ///< ascending
  std::vector<Vec2> pixels;               ///< one per id
  std::optional<BoardExposure> exposure;  ///< empty if the view was not detected in an image
};

/// More squares a side than this are a mistake.
inline constexpr int kMaxSquares = 40;

/// \throw Error (Fault::kUsage) naming the option and what would be right, when no such board can be: fewer
/// than 3 squares a side (a chessboard: 4) or more than kMaxSquares; sizes that are no length up to 2 m; a
/// marker as large as its square; a dictionary that OpenCV lacks, or with fewer markers than the board has
/// squares for.
void checkBoard(const Board& board);

/// "5 x 3 squares of 54 mm, markers of 40 mm, 4X4_50".
std::string describe(const Board& board);
/// A length as it is said to people, to hundredths of a millimetre: "54", "53.85".
std::string inMillimetres(double length_m);

}  // namespace airclay
