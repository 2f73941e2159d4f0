// SPDX-License-Identifier: MIT
// The board's command-line options, shared by the commands that print, detect or record a board.
#pragma once

#include <string>

#include "capture/calibration/board.h"

namespace CLI {
class App;
}

namespace airclay {

/// The options as given.
struct BoardOptions {
  std::string squares = "5x3";  ///< along the width and the height
  double square_mm = 54;
  double marker_mm = 0;  ///< 0: the usual fraction of the square
  std::string dictionary = "4X4_50";
  bool invert = false, chessboard = false, two_sided = false;

  /// \throw Error (Fault::kUsage) if the options do not describe a valid board.
  Board board() const;
};

/// Parses two integers, as in "640x480". \throw Error (Fault::kUsage) naming the option.
std::pair<int, int> parsePair(const std::string& option, const std::string& text);

/// --squares, --square-mm, --marker-mm, --dictionary, --invert, --chessboard, --two-sided.
void addBoardOptions(CLI::App& command, BoardOptions& options);

/// The options that describe `board`.
std::string optionsOf(const Board& board);

}  // namespace airclay
