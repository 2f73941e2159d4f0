// SPDX-License-Identifier: MIT
// A board's pattern: squares, and markers of OpenCV's dictionaries in the white squares of ChArUco boards.
#pragma once

#include <cstdint>
#include <optional>

#include "capture/calibration/board.h"

namespace airclay {

/// Metres in the board's frame.
struct BoardRectangle {
  double left, top, right, bottom;
  bool black;  ///< otherwise white
};

class BoardPattern {
 public:
  /// \throw Error as checkBoard()
  explicit BoardPattern(const Board& board);

  const Board& board() const { return board_; }
  /// Cells along a marker's edge, including its border of one cell; 0 without markers.
  int markerCells() const { return cells_; }
  int markerCount() const { return board_.chessboard ? 0 : board_.squares_x * board_.squares_y / 2; }
  /// The ID of the marker in a square; empty for a black square. \pre the square is on the board
  std::optional<int> markerIn(int column, int row) const;
  /// The upper left corner of a marker. \pre 0 <= id < markerCount()
  Vec2 markerCorner(int id) const;

  /// Whether the board is black at a point of its plane; white beyond its edges.
  bool isBlack(const Vec2& point_m) const;

  /// The pattern as rectangles, to be painted in order on white. Rectangles of one colour overlap only where
  /// one of the other colour is painted between them.
  std::vector<BoardRectangle> rectangles() const;

 private:
  bool isCellWhite(int marker, int row, int column) const {
    return bits_[static_cast<std::size_t>((marker * cells_ + row) * cells_ + column)] != 0;
  }

  Board board_;
  int cells_ = 0;
  std::vector<std::uint8_t> bits_;  ///< of all markers, row by row; 1 where a cell is white
};

}  // namespace airclay
