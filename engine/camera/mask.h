// SPDX-License-Identifier: MIT
// A silhouette as plain pixels.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/camera/rig.h"

namespace airclay {

/// A binary image, one byte per pixel (0: background, anything else: object), row by row from the top. In the
/// camera's raw, distorted image.
struct Mask {
  int width = 0, height = 0;  ///< pixels
  std::vector<std::uint8_t> pixels;
};

/// A mask of the camera's size without any object.
inline Mask emptyMask(const Camera& camera) {
  return {camera.width, camera.height,
          std::vector<std::uint8_t>(std::size_t(camera.width) * std::size_t(camera.height))};
}

}  // namespace airclay
