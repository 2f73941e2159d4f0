// SPDX-License-Identifier: MIT
// The page's layout.
#include <algorithm>
#include <cmath>

#include "capture/calibration/board_image.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

// Most printers cannot print the outermost 4 to 5 mm of a page.
constexpr double kMarginM = 0.005;
constexpr double kFitMarginM = 0.010;
constexpr double kRulerM = 0.1, kTickStepM = 0.01;
constexpr double kTickM = 0.0025, kLineWidthM = 0.0002;
constexpr double kGapM = 0.002;  // between board, ruler and text
// The space below a board: gap, ruler and text.
constexpr double kStripM = kGapM + kTickM + 2 * kTextLineM + 0.001;

struct PageSize {
  double long_m, short_m;
};

PageSize sizeOf(Page page) {
  switch (page) {
    case Page::kA3:
      return {0.420, 0.297};
    case Page::kLetter:
      return {0.2794, 0.2159};
    default:
      return {0.297, 0.210};
  }
}

bool fitsOn(const Board& board, double width_m, double height_m) {
  const double tolerance = 1e-9;
  return board.widthM() + 2 * kMarginM <= width_m + tolerance &&
         board.heightM() + kStripM + 2 * kMarginM <= height_m + tolerance;
}

bool fits(const Board& board, Page page) {
  const PageSize size = sizeOf(page);
  return fitsOn(board, size.long_m, size.short_m) || fitsOn(board, size.short_m, size.long_m);
}

[[noreturn]] void refusePage(const Board& board, Page page) {
  std::string right;
  for (const Page other : {Page::kA4, Page::kLetter, Page::kA3})
    if (right.empty() && fits(board, other)) right = nameOf(other);
  if (right.empty()) right = "fit";
  const double square_m = largestSquare(board.squares_x, board.squares_y, page);
  throw Error("--page " + nameOf(page) + ": a board of " + inMillimetres(board.widthM()) + " x " +
                  inMillimetres(board.heightM()) + " mm does not fit; use --page " + right +
                  (square_m > 0 ? ", or --square-mm " + inMillimetres(square_m) + " at most" : ""),
              Fault::kUsage);
}

void setPage(const Board& board, BoardSheet& sheet) {
  if (sheet.page == Page::kFit) {
    sheet.width_m = std::max(board.widthM(), kRulerM) + 2 * kFitMarginM;
    sheet.height_m = board.heightM() + kStripM + 2 * kFitMarginM;
    return;
  }
  if (!fits(board, sheet.page)) refusePage(board, sheet.page);
  const PageSize size = sizeOf(sheet.page);
  const bool lies = board.widthM() >= board.heightM() ? fitsOn(board, size.long_m, size.short_m)
                                                      : !fitsOn(board, size.short_m, size.long_m);
  sheet.width_m = lies ? size.long_m : size.short_m;
  sheet.height_m = lies ? size.short_m : size.long_m;
}

void addRuler(BoardSheet& sheet) {
  const Vec2 begin = sheet.ruler_begin_m, end = sheet.ruler_end_m;
  const double half = kLineWidthM / 2;
  sheet.ruler.push_back({begin.x() - half, begin.y() - half, end.x() + half, begin.y() + half, true});
  const int ticks = static_cast<int>(std::lround(kRulerM / kTickStepM));
  for (int i = 0; i <= ticks; ++i) {
    const double x = begin.x() + i * kTickStepM, length = i % 5 == 0 ? kTickM : 0.6 * kTickM;
    sheet.ruler.push_back({x - half, begin.y() - length, x + half, begin.y() - half, true});
  }
}

}  // namespace

std::string nameOf(Page page) {
  switch (page) {
    case Page::kA4:
      return "a4";
    case Page::kA3:
      return "a3";
    case Page::kLetter:
      return "letter";
    default:
      return "fit";
  }
}

double largestSquare(int squares_x, int squares_y, Page page) {
  const PageSize size = sizeOf(page);
  double largest = 0;
  for (const auto& [width, height] : {std::pair{size.long_m, size.short_m}, {size.short_m, size.long_m}})
    largest = std::max(
        largest, std::min((width - 2 * kMarginM) / squares_x, (height - 2 * kMarginM - kStripM) / squares_y));
  const double step = largest > 0.01 ? 1e-3 : 1e-4;  // whole millimetres; tenths below 10 mm
  return step * std::floor(largest / step + 1e-9);
}

BoardSheet layOut(const Board& board, Page page) {
  const BoardPattern pattern(board);
  BoardSheet sheet;
  sheet.page = page;
  setPage(board, sheet);
  const double left = (sheet.width_m - board.widthM()) / 2;
  const double top = (sheet.height_m - board.heightM() - kStripM) / 2;
  sheet.board = pattern.rectangles();
  for (BoardRectangle& rectangle : sheet.board) {
    rectangle.left += left, rectangle.right += left;
    rectangle.top += top, rectangle.bottom += top;
  }
  const double ruler_left = std::min(left, (sheet.width_m - kRulerM) / 2);
  sheet.ruler_begin_m = Vec2(ruler_left, top + board.heightM() + kGapM + kTickM);
  sheet.ruler_end_m = sheet.ruler_begin_m + Vec2(kRulerM, 0);
  addRuler(sheet);
  sheet.lines = {"check: this line is 100 mm", "airclay board: " + describe(board)};
  sheet.text_m = sheet.ruler_begin_m + Vec2(0, kTextLineM);
  return sheet;
}

}  // namespace airclay
