// SPDX-License-Identifier: MIT
// Finds a calibration board in an image, its inner corners to a few hundredths of a pixel.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "capture/calibration/board.h"
#include "capture/images/image_file.h"

namespace airclay {

/// Looks for one board, in as many images as wanted and from any number of threads at once.
class BoardDetector {
 public:
  /// \throw Error as checkBoard()
  explicit BoardDetector(const Board& board);
  ~BoardDetector();
  BoardDetector(BoardDetector&&) noexcept;
  BoardDetector& operator=(BoardDetector&&) noexcept;

  const Board& board() const;

  /// The board's inner corners that `pixels` (rows from the top, tightly packed) shows well: of a ChArUco
  /// board at least four in no line; of a chessboard all. A corner that is blurred, hidden, cut off by the
  /// image's edge or of too little contrast is left out. None where the board is not there, or another one
  /// is.
  std::optional<BoardView> find(ImageSize size, PixelFormat form, std::span<const std::uint8_t> pixels) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace airclay
