// SPDX-License-Identifier: MIT
// Where two edges of a chessboard cross in an image, to a few hundredths of a pixel.
#pragma once

#include <cstdint>
#include <optional>

#include "engine/core/math.h"

namespace airclay {

using Mat2 = Eigen::Matrix2d;

/// 8 bits a pixel, rows from the top, tightly packed.
struct GreyImage {
  int width = 0, height = 0;  ///< pixels
  const std::uint8_t* pixels = nullptr;

  double at(int x, int y) const { return pixels[std::ptrdiff_t(y) * width + x]; }
};

/// What is known of a crossing before it is looked at.
struct SaddleGuess {
  Vec2 pixel = Vec2::Zero();
  /// Of the board's axes about the crossing: how a step of one square moves in the image.
  Mat2 pixels_from_squares = Mat2::Identity();
  /// Whether the squares before it and behind it on both axes are the black ones; else the other two.
  bool black_before = true;
  /// How far the white squares are white, from their edges inwards; then comes a marker. In squares.
  double white_margin = 1;
};

struct SaddlePoint {
  Vec2 pixel = Vec2::Zero();
  double blur_px = 0;   ///< sigma of the edges
  double mean = 0;      ///< of black and white, grey values
  double contrast = 0;  ///< white less black, grey values; negative where the black squares are the others
};

/// The crossing near the guess, or none where nothing of that form is there: too far off, blurred beyond a
/// seventh of a square, too little contrast for what else is in its neighbourhood, or cut off by the
/// image's edge.
std::optional<SaddlePoint> findSaddle(const GreyImage& image, const SaddleGuess& guess);
/// The same if the black squares are those that the guess says; otherwise none.
std::optional<SaddlePoint> findCorner(const GreyImage& image, const SaddleGuess& guess);

}  // namespace airclay
