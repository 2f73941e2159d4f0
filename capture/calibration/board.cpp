// SPDX-License-Identifier: MIT
#include "capture/calibration/board.h"

#include <cmath>
#include <opencv2/aruco.hpp>
#include <sstream>

#include "capture/calibration/aruco_dictionary.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

// Larger boards are not practical to print or to hold.
constexpr double kMaxSquareM = 2;

[[noreturn]] void reject(const std::string& message) {
  throw Error(message, Fault::kUsage);
}

void checkLength(const std::string& option, double length_m) {
  if (std::isfinite(length_m) && length_m > 0 && length_m <= kMaxSquareM) return;
  reject(option + " " + inMillimetres(length_m) + ": expected more than 0 and at most " +
         inMillimetres(kMaxSquareM) + " millimetres");
}

}  // namespace

std::optional<ArucoDictionary> arucoDictionary(const std::string& name) {
  if (name == "ARUCO_ORIGINAL") return ArucoDictionary{cv::aruco::DICT_ARUCO_ORIGINAL, 1024, 5};
  int number = cv::aruco::DICT_4X4_50;  // the enumerators are ordered by bits, then by number of markers
  for (int bits = 4; bits <= 7; ++bits)
    for (const int markers : {50, 100, 250, 1000}) {
      const std::string side = std::to_string(bits);
      if (name == side + "X" + side + "_" + std::to_string(markers))
        return ArucoDictionary{number, markers, bits};
      ++number;
    }
  return std::nullopt;
}

void checkBoard(const Board& board) {
  const int fewest = std::min(board.squares_x, board.squares_y);
  const int most = std::max(board.squares_x, board.squares_y);
  const std::string squares =
      "--squares " + std::to_string(board.squares_x) + "x" + std::to_string(board.squares_y) + ": ";
  // A pose needs four corners that are not collinear. OpenCV finds chessboards only from 3 x 3 corners.
  const int at_least = board.chessboard ? 4 : 3;
  if (fewest < at_least || most > kMaxSquares)
    reject(squares + "expected " + std::to_string(at_least) + " to " + std::to_string(kMaxSquares) +
           " squares along each side");
  checkLength("--square-mm", board.square_m);
  if (board.chessboard && board.two_sided)
    reject(
        "--two-sided: a chessboard's back cannot be distinguished from its front; use a board with markers");
  if (board.chessboard) return;
  checkLength("--marker-mm", board.marker_m);
  if (board.marker_m >= board.square_m)
    reject("--marker-mm " + inMillimetres(board.marker_m) + ": a marker must be smaller than its square of " +
           inMillimetres(board.square_m) + " mm; expected about " + inMillimetres(0.75 * board.square_m));
  const std::optional<ArucoDictionary> dictionary = arucoDictionary(board.dictionary);
  if (!dictionary)
    reject("--dictionary " + board.dictionary +
           ": expected 4X4_50, 4X4_100, 4X4_250, 4X4_1000, the same with 5X5, 6X6 or 7X7, or ARUCO_ORIGINAL");
  const int required = board.squares_x * board.squares_y / 2;
  if (required > dictionary->markers)
    reject(squares + "requires " + std::to_string(required) + " markers, but --dictionary " +
           board.dictionary + " has " + std::to_string(dictionary->markers) +
           "; use fewer squares or a larger dictionary");
}

std::string inMillimetres(double length_m) {
  std::ostringstream out;
  out << std::round(1e5 * length_m) / 100;
  return out.str();
}

std::string describe(const Board& board) {
  std::string text = std::to_string(board.squares_x) + " x " + std::to_string(board.squares_y) +
                     " squares of " + inMillimetres(board.square_m) + " mm";
  if (!board.chessboard) text += ", markers of " + inMillimetres(board.marker_m) + " mm, " + board.dictionary;
  return text + (board.inverted ? ", inverted" : "");
}

}  // namespace airclay
