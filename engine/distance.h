// SPDX-License-Identifier: MIT
// Signed distance to the voxel model on a cube of cells around the hand: the continuous measure of how far *outside* a patch is.
#pragma once

#include "engine/carve.h"
#include "shaders/distance_io.h"

namespace airclay {

/// Where the cube of cells lies, in the workspace's frame.
struct FieldGrid {
  FieldPlace place{};  ///< in voxels
  Vec3 low = Vec3::Zero();  ///< the first cell's centre, metres, from the workspace's centre
  double cell_m = 0;
};

/// The cube that holds `reach_m` around `center` (workspace's frame): cells as small as the voxels where they reach that far.
FieldGrid placeField(const Carver& carver, const Vec3& center, double reach_m);

class DistanceField {
 public:
  explicit DistanceField(Gpu& gpu);
  /// Records the distances to the carver's model over `grid`.
  void record(Recorder& recorder, const Carver& carver, const FieldGrid& grid);
  /// Metres, positive outside, x fastest, kFieldCells along each axis. Exact to kFieldReach cells outside and kFieldInnerReach inside.
  const Buffer<float>& distances() const { return distances_; }

 private:
  Kernel<DistanceRowArgs> rows_;
  Kernel<DistanceLineArgs> lines_;
  Buffer<std::uint32_t> along_x_, along_y_;
  Buffer<float> distances_;
};

/// The reference: the same field by brute force over the cells within reach, in double precision.
std::vector<double> distanceReference(const VoxelGrid& model, const FieldGrid& grid);

/// Trilinear interpolation of a field; outside the cube, the border's value.
double fieldDistance(const std::vector<double>& field, const FieldGrid& grid, const Vec3& point);

}  // namespace airclay
