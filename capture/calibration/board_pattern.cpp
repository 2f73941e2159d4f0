// SPDX-License-Identifier: MIT
// The layout is that of OpenCV 4.6's aruco::CharucoBoard: the upper left square is black, and the white
// squares contain the dictionary's first markers, row by row. tests/calibration/board_test.cpp compares it
// with OpenCV's drawing.
#include "capture/calibration/board_pattern.h"

#include <opencv2/aruco.hpp>

#include "capture/calibration/aruco_dictionary.h"

namespace airclay {
namespace {

constexpr int kBorderCells = 1;

}  // namespace

BoardPattern::BoardPattern(const Board& board) : board_(board) {
  checkBoard(board);
  if (board.chessboard) return;
  const ArucoDictionary dictionary = *arucoDictionary(board.dictionary);
  const cv::Ptr<cv::aruco::Dictionary> markers = cv::aruco::getPredefinedDictionary(dictionary.opencv_number);
  cells_ = markers->markerSize + 2 * kBorderCells;
  for (int id = 0; id < markerCount(); ++id) {
    cv::Mat drawn;  // one pixel per cell
    markers->drawMarker(id, cells_, drawn, kBorderCells);
    for (int row = 0; row < cells_; ++row)
      for (int column = 0; column < cells_; ++column)
        bits_.push_back(drawn.at<std::uint8_t>(row, column) > 127);
  }
}

std::optional<int> BoardPattern::markerIn(int column, int row) const {
  if (board_.chessboard || (column + row) % 2 == 0) return std::nullopt;
  // Preceded by complete pairs of rows, perhaps an even row, then the markers in its own row.
  return row / 2 * board_.squares_x + (row % 2 ? board_.squares_x / 2 : 0) + column / 2;
}

Vec2 BoardPattern::markerCorner(int id) const {
  // Two rows have squares_x markers: the first squares_x / 2 rounded down, in the odd columns.
  const int pair = id / board_.squares_x, rest = id % board_.squares_x, in_first = board_.squares_x / 2;
  const int row = 2 * pair + (rest >= in_first);
  const int column = rest >= in_first ? 2 * (rest - in_first) : 2 * rest + 1;
  const double inset = (board_.square_m - board_.marker_m) / 2;
  return board_.square_m * Vec2(column, row) + Vec2::Constant(inset);
}

bool BoardPattern::isBlack(const Vec2& point_m) const {
  const double x = point_m.x() / board_.square_m, y = point_m.y() / board_.square_m;
  if (!(x >= 0 && y >= 0 && x < board_.squares_x && y < board_.squares_y)) return false;
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  if ((column + row) % 2 == 0) return !board_.inverted;
  const std::optional<int> marker = markerIn(column, row);
  if (!marker) return board_.inverted;
  const Vec2 inside = (point_m - markerCorner(*marker)) * (cells_ / board_.marker_m);
  const bool on_marker = inside.x() >= 0 && inside.y() >= 0 && inside.x() < cells_ && inside.y() < cells_;
  if (!on_marker) return board_.inverted;
  const bool is_white = isCellWhite(*marker, static_cast<int>(inside.y()), static_cast<int>(inside.x()));
  return is_white == board_.inverted;
}

std::vector<BoardRectangle> BoardPattern::rectangles() const {
  const double square = board_.square_m, cell = cells_ ? board_.marker_m / cells_ : 0;
  const bool dark = !board_.inverted;  // the colour of black parts, unless inverted
  std::vector<BoardRectangle> painted;
  if (board_.inverted) painted.push_back({0, 0, board_.widthM(), board_.heightM(), true});
  for (int row = 0; row < board_.squares_y; ++row)
    for (int column = row % 2; column < board_.squares_x; column += 2)
      painted.push_back({column * square, row * square, (column + 1) * square, (row + 1) * square, dark});
  for (int id = 0; id < markerCount(); ++id) {
    const Vec2 at = markerCorner(id);
    painted.push_back({at.x(), at.y(), at.x() + board_.marker_m, at.y() + board_.marker_m, dark});
    for (int row = 0; row < cells_; ++row)
      for (int begin = 0, end; begin < cells_; begin = end + 1) {
        for (end = begin; end < cells_ && isCellWhite(id, row, end);) ++end;
        if (end > begin)
          painted.push_back({at.x() + begin * cell, at.y() + row * cell, at.x() + end * cell,
                             at.y() + (row + 1) * cell, !dark});
      }
  }
  return painted;
}

}  // namespace airclay
