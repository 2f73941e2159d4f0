// SPDX-License-Identifier: MIT
#include "capture/calibration/chessboard_detector.h"

#include <algorithm>
#include <opencv2/calib3d.hpp>

#include "capture/calibration/board_exposure.h"

namespace airclay {
namespace {

/// Corners row by row, in pixels, in any orientation of the board.
struct Grid {
  int columns, rows;
  std::vector<Vec2> pixels;

  const Vec2& at(int column, int row) const {
    return pixels[static_cast<std::size_t>(row * columns + column)];
  }
  /// The board's axes at a corner, one per column: pixels per square.
  Mat2 axesAt(int column, int row) const {
    const int left = std::max(0, column - 1), right = std::min(columns - 1, column + 1);
    const int above = std::max(0, row - 1), below = std::min(rows - 1, row + 1);
    Mat2 axes;
    axes.col(0) = (at(right, row) - at(left, row)) / (right - left);
    axes.col(1) = (at(column, below) - at(column, above)) / (below - above);
    return axes;
  }
  Grid rotated180() const { return {columns, rows, {pixels.rbegin(), pixels.rend()}}; }
  Grid mirrored() const {
    Grid result = *this;
    for (int row = 0; row < rows; ++row)
      std::reverse(result.pixels.begin() + row * columns, result.pixels.begin() + (row + 1) * columns);
    return result;
  }
  /// Rotates by a quarter turn: columns become rows.
  Grid rotated90() const {
    Grid result{rows, columns, {}};
    for (int row = 0; row < columns; ++row)
      for (int column = 0; column < rows; ++column) result.pixels.push_back(at(row, rows - 1 - column));
    return result;
  }
};

/// The contrast at the grid's first corner: negative if the upper left square is white. Empty if no corner
/// fits the image there.
std::optional<double> contrastAtFirst(const GreyImage& image, const Grid& grid) {
  const std::optional<SaddlePoint> saddle = findSaddle(image, {grid.at(0, 0), grid.axesAt(0, 0), true, 1});
  return saddle ? std::optional(saddle->contrast) : std::nullopt;
}

/// The grid in the board's orientation: its upper left square is black, and of several such orientations its
/// rows point right in the image. Empty if the first corner of an orientation does not fit the image.
std::optional<Grid> inBoardOrientation(const GreyImage& image, Grid grid) {
  if (grid.axesAt(0, 0).determinant() < 0) grid = grid.mirrored();
  std::vector<Grid> orientations{grid, grid.rotated180()};
  if (grid.columns == grid.rows) {
    const Grid quarter = grid.rotated90();
    orientations.push_back(quarter);
    orientations.push_back(quarter.rotated180());
  }
  std::optional<Grid> best;
  double best_right = 0;
  for (int colour = 0; colour < 2 && !best; ++colour)  // if none has a black square there, use any
    for (const Grid& orientation : orientations) {
      const std::optional<double> contrast = contrastAtFirst(image, orientation);
      if (!contrast) return std::nullopt;
      if (colour == 0 && *contrast < 0) continue;
      const double right =
          (orientation.at(orientation.columns - 1, 0) - orientation.at(0, 0)).normalized().x();
      if (!best || right > best_right) best = orientation, best_right = right;
    }
  return best;
}

}  // namespace

std::optional<BoardView> findChessboard(const Board& board, const GreyImage& image) {
  // cv::Mat has no read-only view; OpenCV only reads these pixels.
  const cv::Mat grey(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels));
  std::vector<cv::Point2f> corners;
  const cv::Size size(board.cornersX(), board.cornersY());
  // First with a global threshold, then with an adaptive one. OpenCV's default uses both at once and takes
  // seconds if the board in the image has different numbers of squares.
  if (!cv::findChessboardCorners(grey, size, corners, cv::CALIB_CB_NORMALIZE_IMAGE) &&
      !cv::findChessboardCorners(grey, size, corners, cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_FAST_CHECK))
    return std::nullopt;
  Grid found{size.width, size.height, {}};
  for (const cv::Point2f& corner : corners) found.pixels.emplace_back(corner.x, corner.y);
  const std::optional<Grid> grid = inBoardOrientation(image, found);
  if (!grid) return std::nullopt;

  const std::optional<double> first = contrastAtFirst(image, *grid);
  BoardView view;
  std::vector<SaddlePoint> corners_in_order;
  for (int id = 0; id < board.cornerCount(); ++id) {
    const int column = id % grid->columns, row = id / grid->columns;
    const bool black_before = board.blackBefore(id) == (first && *first > 0);
    const std::optional<SaddlePoint> corner =
        findCorner(image, {grid->at(column, row), grid->axesAt(column, row), black_before, 1});
    if (!corner) return std::nullopt;
    view.ids.push_back(id);
    view.pixels.push_back(corner->pixel);
    corners_in_order.push_back(*corner);
  }
  view.exposure = exposureOf(corners_in_order);
  return view;
}

}  // namespace airclay
