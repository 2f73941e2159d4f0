// SPDX-License-Identifier: MIT
// Calibration boards to be printed, true to scale: as a PDF of exact edges, or as a PNG.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "capture/calibration/board_pattern.h"

namespace airclay {

/// Paper: A4, A3, US letter, or as large as the board.
enum class Page { kA4, kA3, kLetter, kFit };

/// By the words of --page: a4, a3, letter, fit.
std::string nameOf(Page page);

/// A page with a board on it, and below the board a line of 100 mm and what was printed. Metres, from the
/// page's upper left corner, y down; lengths stand as they will on paper.
struct BoardSheet {
  Page page = Page::kA4;
  double width_m = 0, height_m = 0;  ///< of the page, on its side where that suits the board
  std::vector<BoardRectangle> board;
  std::vector<BoardRectangle> ruler;
  Vec2 ruler_begin_m = Vec2::Zero(), ruler_end_m = Vec2::Zero();  ///< 100 mm from each other
  std::vector<std::string> lines;                                 ///< of text
  Vec2 text_m = Vec2::Zero();                                     ///< where the first line's letters stand
};

/// Letters' height and the way from line to line, metres.
inline constexpr double kTextSizeM = 0.0026, kTextLineM = 0.0032;

/// \throw Error as checkBoard(); or (Fault::kUsage) when the board does not fit the page: says which page, or
/// which --square-mm, would be right.
BoardSheet layOut(const Board& board, Page page);

/// The largest squares, in metres, that a board of that many would have on the page; 0 where none fit.
double largestSquare(int squares_x, int squares_y, Page page);

/// One page of filled paths; what reads PDF files is told not to scale it in print. The file appears whole or
/// not at all. \throw Error when it cannot be written or the page is larger than a PDF can be.
void writeBoardPdf(const std::filesystem::path& file, const BoardSheet& sheet);

/// Grey, its resolution said in the file. An edge that falls inside a pixel makes it grey by its share.
/// \throw Error when it cannot be written, or has more pixels than kMostBoardPixels.
void writeBoardPng(const std::filesystem::path& file, const BoardSheet& sheet, double dpi);

/// A2 at 600 dpi is as much.
inline constexpr double kMostBoardPixels = 140e6;

}  // namespace airclay
