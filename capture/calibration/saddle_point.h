// SPDX-License-Identifier: MIT
// Locates a chessboard corner in an image to a few hundredths of a pixel.
#pragma once

#include <cstdint>
#include <optional>

#include "engine/core/math.h"

namespace airclay {

using Mat2 = Eigen::Matrix2d;

/// A view of an image: 8 bits per pixel, rows from the top without padding.
struct GreyImage {
  int width = 0, height = 0;  ///< pixels
  const std::uint8_t* pixels = nullptr;

  double at(int x, int y) const { return pixels[std::ptrdiff_t(y) * width + x]; }
};

/// The initial estimate of a corner.
struct SaddleGuess {
  Vec2 pixel = Vec2::Zero();
  /// The board's axes at the corner, one per column: pixels per square.
  Mat2 pixels_from_squares = Mat2::Identity();
  /// Whether the two squares on the same side of both axes (upper left and lower right) are black; otherwise
  /// the other two are.
  bool black_before = true;
  /// The width of the white margin between a square's edge and its marker, in squares.
  double white_margin = 1;
};

/// A fitted corner.
struct SaddlePoint {
  Vec2 pixel = Vec2::Zero();
  double blur_px = 0;   ///< standard deviation of the blur across edges
  double mean = 0;      ///< of black and white, grey values
  double contrast = 0;  ///< white - black, grey values; negative if the other two squares are black
};

/// Fits a corner near the guess. Empty if the image shows none there: it is too far from the guess, blurred
/// by more than a seventh of a square, low in contrast compared with the fit's residual, or cut off by the
/// image's edge.
std::optional<SaddlePoint> findSaddle(const GreyImage& image, const SaddleGuess& guess);
/// Like findSaddle(), but empty if the black squares are not those of the guess.
std::optional<SaddlePoint> findCorner(const GreyImage& image, const SaddleGuess& guess);

}  // namespace airclay
