// SPDX-License-Identifier: MIT
// Printable calibration boards, true to scale: PDF or PNG.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "capture/calibration/board_pattern.h"

namespace airclay {

/// Paper: A4, A3, US letter, or as large as the board.
enum class Page { kA4, kA3, kLetter, kFit };

/// The value of --page: a4, a3, letter, fit.
std::string nameOf(Page page);

/// A page with a board, and below it a ruler of 100 mm and a description. Metres on paper, from the page's
/// upper left corner, y down.
struct BoardSheet {
  Page page = Page::kA4;
  double width_m = 0, height_m = 0;  ///< of the page; landscape if that suits the board
  std::vector<BoardRectangle> board;
  std::vector<BoardRectangle> ruler;
  Vec2 ruler_begin_m = Vec2::Zero(), ruler_end_m = Vec2::Zero();  ///< 100 mm apart
  std::vector<std::string> lines;                                 ///< the description
  Vec2 text_m = Vec2::Zero();                                     ///< start of the first line's baseline
};

/// Font size and line spacing, metres.
inline constexpr double kTextSizeM = 0.0026, kTextLineM = 0.0032;

/// \throw Error as checkBoard(); with Fault::kUsage if the board does not fit the page: names a page or a
/// --square-mm that fits.
BoardSheet layOut(const Board& board, Page page);

/// The largest square size, in metres, with which such a board fits the page; 0 if none does.
double largestSquare(int squares_x, int squares_y, Page page);

/// Writes one page of filled paths that viewers print without scaling, atomically.
/// \throw Error if the file cannot be written, or the page exceeds PDF's maximum.
void writeBoardPdf(const std::filesystem::path& file, const BoardSheet& sheet);

/// Writes a grey image with antialiased edges; the file states the resolution.
/// \throw Error if the file cannot be written, or has more than kMaxBoardPixels pixels.
void writeBoardPng(const std::filesystem::path& file, const BoardSheet& sheet, double dpi);

/// A2 at 600 dpi.
inline constexpr double kMaxBoardPixels = 140e6;

}  // namespace airclay
