// SPDX-License-Identifier: MIT
// A binary silhouette image.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/camera/rig.h"

namespace airclay {

/// A binary image, one byte per pixel (0: background, otherwise object), row-major from the top left, in the
/// camera's raw (distorted) image.
struct Mask {
  int width = 0, height = 0;  ///< pixels
  std::vector<std::uint8_t> pixels;
};

/// An all-background mask of the camera's size.
inline Mask emptyMask(const Camera& camera) {
  return {camera.width, camera.height,
          std::vector<std::uint8_t>(std::size_t(camera.width) * std::size_t(camera.height))};
}

}  // namespace airclay
