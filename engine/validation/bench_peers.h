// SPDX-License-Identifier: MIT
// The peers of `airclay bench`: straightforward, well-written C++ in single precision on two threads.
#pragma once

#include "engine/hull/carve.h"
#include "engine/silhouette/silhouette.h"

namespace airclay {

/// Carves voxel by voxel: steps along a row in each camera's frame, projects with the lens polynomials, and
/// looks up the byte mask; the first miss ends the voxel.
class CarveLoop {
 public:
  /// \throw Error for a fisheye or rational lens, which the loop does not support.
  CarveLoop(const Rig& rig, int voxels);
  /// Uses the masks without preprocessing. \pre each has its camera's size
  void run(const std::vector<Silhouette>& masks);
  bool at(int x, int y, int z) const {
    const std::size_t row = std::size_t(y) + std::size_t(voxels_) * std::size_t(z);
    return occupied_[row * row_words_ + std::size_t(x) / 32] >> (x % 32) & 1;
  }

 private:
  /// A camera whose world is measured in voxels, with the origin at voxel 0's centre.
  struct View {
    std::array<float, 3> origin, along_x, along_y, along_z;
    float fx, fy, cx, cy, k1, k2, p1, p2, k3, limit_square;
    float width, height;
  };
  void carveLayers(const std::vector<Silhouette>& masks, int first, int step);

  int voxels_;
  std::size_t row_words_;
  std::vector<View> views_;
  std::vector<std::uint32_t> occupied_;  ///< one bit per voxel; rows along x are whole words
};

/// The silhouette stage, image by image: scores, edges, majority; largest part and holes by flood fill.
class SilhouetteLoop {
 public:
  /// `backgrounds`: one model per camera.
  SilhouetteLoop(const Rig& rig, const std::vector<std::vector<BackgroundPixel>>& backgrounds);
  /// `images`: one BGR image per camera, rows without padding.
  void run(const std::vector<std::span<const std::uint8_t>>& images);
  const std::vector<Silhouette>& masks() const { return masks_; }

 private:
  struct BackgroundFloats {
    float b, g, r, spread;
  };
  struct Scratch {
    std::vector<std::int8_t> octaves;
    std::vector<std::uint8_t> segmented, majority, visited;
    std::vector<int> part, largest;
  };
  void segment(std::size_t camera, std::span<const std::uint8_t> bgr);

  std::vector<std::vector<BackgroundFloats>> backgrounds_;
  std::vector<Scratch> scratch_;
  std::vector<Silhouette> masks_;
};

}  // namespace airclay
