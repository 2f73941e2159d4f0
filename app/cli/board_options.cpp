// SPDX-License-Identifier: MIT
#include "app/cli/board_options.h"

#include <CLI/CLI.hpp>
#include <cstdio>

#include "app/cli/command.h"
#include "capture/calibration/board_advice.h"
#include "engine/core/error.h"

namespace airclay {
std::pair<int, int> parsePair(const std::string& option, const std::string& text) {
  int first = 0, second = 0, read = 0;
  const bool is_pair = std::sscanf(text.c_str(), "%6dx%6d%n", &first, &second, &read) == 2 &&
                       static_cast<std::size_t>(read) == text.size();
  if (!is_pair || first < 1 || second < 1)
    throw Error(option + " " + oneLine(text) + ": expected two whole numbers with an x between them, as in " +
                    (option == "--squares" ? "5x3" : "640x480"),
                Fault::kUsage);
  return {first, second};
}

Board BoardOptions::board() const {
  Board board;
  std::tie(board.squares_x, board.squares_y) = parsePair("--squares", squares);
  board.square_m = square_mm / 1000;
  board.marker_m = marker_mm != 0 ? marker_mm / 1000 : defaultMarker(board.square_m);
  board.dictionary = dictionary.starts_with("DICT_") ? dictionary.substr(5) : dictionary;
  board.inverted = invert;
  board.chessboard = chessboard;
  board.two_sided = two_sided;
  checkBoard(board);
  return board;
}

void addBoardOptions(CLI::App& command, BoardOptions& options) {
  command
      .add_option("--squares", options.squares, "number of squares along the board's width and height [5x3]")
      ->type_name("NxM");
  command
      .add_option("--square-mm", options.square_mm,
                  "edge of a square in millimetres, as measured on the print [54]")
      ->type_name("MM");
  command
      .add_option("--marker-mm", options.marker_mm,
                  "edge of a marker in millimetres [about three quarters of the square: 40]")
      ->type_name("MM");
  command.add_option("--dictionary", options.dictionary, "OpenCV marker dictionary [4X4_50]")
      ->type_name("NAME");
  command.add_flag("--invert", options.invert, "swap black and white");
  command.add_flag("--chessboard", options.chessboard, "use a plain chessboard, without markers");
  command.add_flag("--two-sided", options.two_sided,
                   "the back of the board has the mirrored pattern, corner behind corner");
}

std::string optionsOf(const Board& board) {
  std::string text = "--squares " + std::to_string(board.squares_x) + "x" + std::to_string(board.squares_y) +
                     " --square-mm " + inMillimetres(board.square_m);
  if (!board.chessboard)
    text += " --marker-mm " + inMillimetres(board.marker_m) + " --dictionary " + board.dictionary;
  return text + (board.inverted ? " --invert" : "") + (board.chessboard ? " --chessboard" : "") +
         (board.two_sided ? " --two-sided" : "");
}

}  // namespace airclay
