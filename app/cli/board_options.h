// SPDX-License-Identifier: MIT
// The board's words on the command line, shared by the commands that print, see or record one.
#pragma once

#include <string>

#include "capture/calibration/board.h"

namespace CLI {
class App;
}

namespace airclay {

/// A board as written.
struct BoardOptions {
  std::string squares = "5x3";  ///< along its width and its height
  double square_mm = 54;
  double marker_mm = 0;  ///< 0: the usual share of the square
  std::string dictionary = "4X4_50";
  bool invert = false, chessboard = false, two_sided = false;

  /// \throw Error (Fault::kUsage) when they make no board.
  Board board() const;
};

/// Whole numbers as written in "640x480". \throw Error (Fault::kUsage) naming the option.
std::pair<int, int> parsePair(const std::string& option, const std::string& text);

/// --squares, --square-mm, --marker-mm, --dictionary, --invert, --chessboard, --two-sided.
void addBoardOptions(CLI::App& command, BoardOptions& options);

/// The words that say it on the command line.
std::string optionsOf(const Board& board);

}  // namespace airclay
