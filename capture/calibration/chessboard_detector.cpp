// SPDX-License-Identifier: MIT
#include "capture/calibration/chessboard_detector.h"

#include <algorithm>
#include <opencv2/calib3d.hpp>

#include "capture/calibration/board_exposure.h"

namespace airclay {
namespace {

/// Corners row by row, as OpenCV found them, in any of the ways in which a board can lie.
struct Grid {
  int columns, rows;
  std::vector<Vec2> pixels;

  const Vec2& at(int column, int row) const {
    return pixels[static_cast<std::size_t>(row * columns + column)];
  }
  /// How a step of one square moves at a corner.
  Mat2 slopeAt(int column, int row) const {
    const int left = std::max(0, column - 1), right = std::min(columns - 1, column + 1);
    const int above = std::max(0, row - 1), below = std::min(rows - 1, row + 1);
    Mat2 slope;
    slope.col(0) = (at(right, row) - at(left, row)) / (right - left);
    slope.col(1) = (at(column, below) - at(column, above)) / (below - above);
    return slope;
  }
  Grid turned() const { return {columns, rows, {pixels.rbegin(), pixels.rend()}}; }
  Grid mirrored() const {
    Grid made = *this;
    for (int row = 0; row < rows; ++row)
      std::reverse(made.pixels.begin() + row * columns, made.pixels.begin() + (row + 1) * columns);
    return made;
  }
  /// Of a square grid: columns become rows, a quarter turn.
  Grid quarterTurned() const {
    Grid made{rows, columns, {}};
    for (int row = 0; row < columns; ++row)
      for (int column = 0; column < rows; ++column) made.pixels.push_back(at(row, rows - 1 - column));
    return made;
  }
};

/// The contrast at the grid's first corner: negative where its upper left square is white.
std::optional<double> contrastAtFirst(const GreyImage& image, const Grid& grid) {
  const std::optional<SaddlePoint> saddle = findSaddle(image, {grid.at(0, 0), grid.slopeAt(0, 0), true, 1});
  return saddle ? std::optional(saddle->contrast) : std::nullopt;
}

/// The way in which the board lies: its upper left square is black, and where that leaves a choice its rows
/// run to the right.
std::optional<Grid> asTheBoardLies(const GreyImage& image, Grid grid) {
  if (grid.slopeAt(0, 0).determinant() < 0) grid = grid.mirrored();
  std::vector<Grid> ways{grid, grid.turned()};
  if (grid.columns == grid.rows) {
    const Grid quarter = grid.quarterTurned();
    ways.push_back(quarter);
    ways.push_back(quarter.turned());
  }
  std::optional<Grid> best;
  double best_right = 0;
  for (int colour = 0; colour < 2 && !best; ++colour)  // where no way has a black one, any will do
    for (const Grid& way : ways) {
      const std::optional<double> contrast = contrastAtFirst(image, way);
      if (!contrast) return std::nullopt;
      if (colour == 0 && *contrast < 0) continue;
      const double right = (way.at(way.columns - 1, 0) - way.at(0, 0)).normalized().x();
      if (!best || right > best_right) best = way, best_right = right;
    }
  return best;
}

}  // namespace

std::optional<BoardView> findChessboard(const Board& board, const GreyImage& image) {
  // OpenCV only reads from it, but has no constant matrix over foreign memory.
  const cv::Mat grey(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels));
  std::vector<cv::Point2f> corners;
  const cv::Size size(board.cornersX(), board.cornersY());
  // One threshold for the whole image first, then one for each neighbourhood. Both at once, OpenCV's usual
  // choice, takes seconds over an image of a board with other numbers of squares.
  if (!cv::findChessboardCorners(grey, size, corners, cv::CALIB_CB_NORMALIZE_IMAGE) &&
      !cv::findChessboardCorners(grey, size, corners, cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_FAST_CHECK))
    return std::nullopt;
  Grid found{size.width, size.height, {}};
  for (const cv::Point2f& corner : corners) found.pixels.emplace_back(corner.x, corner.y);
  const std::optional<Grid> grid = asTheBoardLies(image, found);
  if (!grid) return std::nullopt;

  const std::optional<double> first = contrastAtFirst(image, *grid);
  BoardView view;
  std::vector<SaddlePoint> corners_in_order;
  for (int id = 0; id < board.cornerCount(); ++id) {
    const int column = id % grid->columns, row = id / grid->columns;
    const bool black_before = board.blackBefore(id) == (first && *first > 0);
    const std::optional<SaddlePoint> corner =
        findCorner(image, {grid->at(column, row), grid->slopeAt(column, row), black_before, 1});
    if (!corner) return std::nullopt;
    view.ids.push_back(id);
    view.pixels.push_back(corner->pixel);
    corners_in_order.push_back(*corner);
  }
  view.exposure = exposureOf(corners_in_order);
  return view;
}

}  // namespace airclay
