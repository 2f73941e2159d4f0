// SPDX-License-Identifier: MIT
// The silhouette of the hand in one camera: a probability per pixel, or a mask.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/camera/rig.h"

namespace airclay {

/// One byte per pixel, row-major from the top left, in the camera's raw (distorted) image: the probability
/// that the pixel shows the hand, from 0 to 255. A mask uses only 0 and 255.
struct Silhouette {
  /// A pixel belongs to the hand from this value on.
  static constexpr std::uint8_t kThreshold = 128;

  int width = 0, height = 0;  ///< pixels
  std::vector<std::uint8_t> pixels;

  /// \pre 0 <= x < width, 0 <= y < height
  bool contains(int x, int y) const {
    return pixels[std::size_t(y) * std::size_t(width) + std::size_t(x)] >= kThreshold;
  }
};

/// A silhouette of the camera's size without a hand.
inline Silhouette emptySilhouette(const Camera& camera) {
  return {camera.width, camera.height,
          std::vector<std::uint8_t>(std::size_t(camera.width) * std::size_t(camera.height))};
}

}  // namespace airclay
