// SPDX-License-Identifier: MIT
// Detects a calibration board in an image, and locates its inner corners to a few hundredths of a pixel.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "capture/calibration/board.h"
#include "capture/images/image_file.h"

namespace airclay {

/// Detects one board. find() is thread-safe.
class BoardDetector {
 public:
  /// \throw Error as checkBoard()
  explicit BoardDetector(const Board& board);
  ~BoardDetector();
  BoardDetector(BoardDetector&&) noexcept;
  BoardDetector& operator=(BoardDetector&&) noexcept;

  const Board& board() const;

  /// The board's visible inner corners: of a ChArUco board at least four that are not collinear, of a
  /// chessboard all. Omits corners that are blurred, hidden, low in contrast, or cut off by the image's edge.
  /// Empty if the image does not show this board. `pixels`: rows from the top without padding. \throw Error
  /// if `pixels` does not have the size of such an image
  std::optional<BoardView> find(ImageSize size, PixelFormat format,
                                std::span<const std::uint8_t> pixels) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace airclay
