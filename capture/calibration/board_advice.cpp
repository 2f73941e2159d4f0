// SPDX-License-Identifier: MIT
#include "capture/calibration/board_advice.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "capture/calibration/aruco_dictionary.h"
#include "engine/core/median.h"

namespace airclay {
namespace {

// Added to the unprintable margin of the best printers (5 mm): most printers leave more, and a hand needs
// space to hold the board.
constexpr double kExtraMarginM = 0.005;

constexpr std::pair<int, int> kGrids[] = {{9, 6}, {8, 6}, {8, 5}, {7, 5}, {6, 5},
                                          {6, 4}, {5, 4}, {5, 3}, {4, 3}, {3, 3}};

// Boards are reported as too small below this fraction of the required size; synthetic boards of 0.9 of it
// still calibrate.
constexpr double kTooSmall = 0.83;

/// Cells along a marker's side, including its border; 1 for a chessboard.
int markerCells(const Board& board) {
  return board.chessboard ? 1 : arucoDictionary(board.dictionary)->bits + 2;
}

double cellM(const Board& board) {
  return (board.chessboard ? board.square_m : board.marker_m) / markerCells(board);
}

/// The largest board with this grid of squares that fits the page. Empty if none fits, or a chessboard would
/// be ambiguous.
std::optional<Board> largestOnPage(const Board& requested, std::pair<int, int> grid, Page page) {
  Board board = requested;
  std::tie(board.squares_x, board.squares_y) = grid;
  const bool fills = largestSquare(grid.first, grid.second, page) > 0;
  if (!fills || (board.chessboard && (std::min(grid.first, grid.second) < 4 || board.isAmbiguous())))
    return std::nullopt;
  // in whole millimetres, with the extra margin
  board.square_m =
      std::round(1e3 * largestSquare(grid.first, grid.second, page)) / 1e3 - 2 * kExtraMarginM / grid.first;
  board.square_m = std::floor(1e3 * board.square_m) / 1e3;
  board.marker_m = defaultMarker(board.square_m);
  if (!board.chessboard && arucoDictionary(board.dictionary)->bits > 4) board.dictionary = "4X4_50";
  return board;
}

/// The side of a square in pixels, along the board axis that its tilt shortens less. Empty if the view has no
/// two neighbouring corners.
std::optional<double> squarePixels(const Board& board, const BoardView& view) {
  std::vector<double> along_rows_px, along_columns_px;
  for (std::size_t i = 0; i < view.ids.size(); ++i)
    for (std::size_t j = i + 1; j < view.ids.size(); ++j) {
      const int a = view.ids[i], b = view.ids[j];
      const double side_px = (view.pixels[i] - view.pixels[j]).norm();
      if (b == a + 1 && b % board.cornersX() != 0) along_rows_px.push_back(side_px);
      if (b == a + board.cornersX()) along_columns_px.push_back(side_px);
    }
  std::optional<double> longest_px;
  for (const std::vector<double>& sides_px : {along_rows_px, along_columns_px})
    if (!sides_px.empty()) longest_px = std::max(longest_px.value_or(0), median(sides_px));
  return longest_px;
}

}  // namespace

double focalOf(int width, double fov_degrees) {
  return width / 2.0 / std::tan(fov_degrees * std::numbers::pi / 360);
}

double cellPixels(const Board& board, const BoardSight& sight) {
  return cellM(board) * sight.focal_px / sight.distance_m;
}

double minCellPixels(const Board& board) {
  return board.chessboard ? 10 : 3;
}

std::optional<double> markerPixels(const Board& board, std::span<const BoardView* const> views) {
  std::vector<double> squares_px;
  for (const BoardView* view : views)
    if (const std::optional<double> side_px = squarePixels(board, *view)) squares_px.push_back(*side_px);
  if (squares_px.empty()) return std::nullopt;
  return median(squares_px) * (board.chessboard ? 1 : board.marker_m / board.square_m);
}

double minMarkerPixels(const Board& board) {
  return minCellPixels(board) * markerCells(board);
}

std::string describeSmallBoard(const Board& board, double marker_px) {
  const double min_px = minMarkerPixels(board);
  if (marker_px >= kTooSmall * min_px) return "";
  const auto tenths = [](double value) {
    const std::string text = std::to_string(std::ceil(10 * value) / 10);
    return text.substr(0, text.find('.') + 2);
  };
  const std::string parts = board.chessboard ? "squares" : "markers";
  return "the board is too small in the image: the sides of its " + parts + " measure " +
         std::to_string(std::lround(std::floor(marker_px))) + " px, and at least " +
         std::to_string(std::lround(std::ceil(min_px))) + " px are needed; hold it closer, print its " +
         parts + " " + tenths(min_px / marker_px) + " times as large, or record at a higher resolution";
}

std::optional<BoardProposal> readableBoard(const Board& requested, const BoardSight& sight, Page page) {
  for (const Page candidate : {Page::kA4, Page::kA3}) {
    if (page == Page::kA3 && candidate == Page::kA4) continue;
    for (const std::pair<int, int>& grid : kGrids) {
      const std::optional<Board> board = largestOnPage(requested, grid, candidate);
      if (!board) continue;
      const double cell_px = cellPixels(*board, sight);
      if (cell_px >= minCellPixels(*board)) return BoardProposal{*board, candidate, cell_px};
    }
  }
  return std::nullopt;
}

double defaultMarker(double square_m) {
  const double marker_mm = 740 * square_m, step = marker_mm < 10 ? 0.1 : 1;
  return step * std::round(marker_mm / step) / 1000;
}

}  // namespace airclay
