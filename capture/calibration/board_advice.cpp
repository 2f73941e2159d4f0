// SPDX-License-Identifier: MIT
#include "capture/calibration/board_advice.h"

#include <cmath>
#include <numbers>

#include "capture/calibration/aruco_dictionary.h"

namespace airclay {
namespace {

// What a printer leaves white is more than the 5 mm of the best; and one holds a board by its margin.
constexpr double kComfortM = 0.005;

constexpr std::pair<int, int> kGrids[] = {{9, 6}, {8, 6}, {8, 5}, {7, 5}, {6, 5},
                                          {6, 4}, {5, 4}, {5, 3}, {4, 3}, {3, 3}};

double cellM(const Board& board) {
  return board.chessboard ? board.square_m : board.marker_m / (arucoDictionary(board.dictionary)->bits + 2);
}

/// The board of so many squares, as large as the page allows.
std::optional<Board> onPage(const Board& requested, std::pair<int, int> grid, Page page) {
  Board board = requested;
  std::tie(board.squares_x, board.squares_y) = grid;
  const bool fills = largestSquare(grid.first, grid.second, page) > 0;
  if (!fills || (board.chessboard && (std::min(grid.first, grid.second) < 4 || board.isAmbiguous())))
    return std::nullopt;
  // Squares of whole millimetres, with some white to hold it by.
  board.square_m =
      std::round(1e3 * largestSquare(grid.first, grid.second, page)) / 1e3 - 2 * kComfortM / grid.first;
  board.square_m = std::floor(1e3 * board.square_m) / 1e3;
  board.marker_m = usualMarker(board.square_m);
  if (!board.chessboard && arucoDictionary(board.dictionary)->bits > 4) board.dictionary = "4X4_50";
  return board;
}

}  // namespace

double focalOf(int width, double fov_degrees) {
  return width / 2.0 / std::tan(fov_degrees * std::numbers::pi / 360);
}

double cellPixels(const Board& board, const BoardSight& sight) {
  return cellM(board) * sight.focal_px / sight.distance_m;
}

double leastCellPixels(const Board& board) {
  return board.chessboard ? 10 : 3;
}

std::optional<BoardProposal> readableBoard(const Board& requested, const BoardSight& sight, Page page) {
  for (const Page candidate : {Page::kA4, Page::kA3}) {
    if (page == Page::kA3 && candidate == Page::kA4) continue;
    for (const std::pair<int, int>& grid : kGrids) {
      const std::optional<Board> board = onPage(requested, grid, candidate);
      if (!board) continue;
      const double cell_px = cellPixels(*board, sight);
      if (cell_px >= leastCellPixels(*board)) return BoardProposal{*board, candidate, cell_px};
    }
  }
  return std::nullopt;
}

double usualMarker(double square_m) {
  const double marker_mm = 740 * square_m, step = marker_mm < 10 ? 0.1 : 1;
  return step * std::round(marker_mm / step) / 1000;
}

}  // namespace airclay
