// SPDX-License-Identifier: MIT
// The signed distance to the voxel model on a box of cells around the hand: a continuous measure of how far a
// hand patch is *outside* the model.
#pragma once

#include "engine/hull/carve.h"
#include "shaders/hull/distance_io.h"

namespace airclay {

/// The box of cells, in the workspace frame.
struct FieldGrid {
  FieldPlace place{};       ///< in voxels
  Vec3 low = Vec3::Zero();  ///< the first cell's centre, workspace frame, metres
  double cell_m = 0;

  std::size_t cells() const { return std::size_t(place.size[0]) * place.size[1] * place.size[2]; }
  std::size_t index(int x, int y, int z) const {
    return std::size_t(x) + place.size[0] * (std::size_t(y) + place.size[1] * std::size_t(z));
  }
};

/// A box that contains `center` ± `half_size_m` (workspace frame). A cell is the smallest whole number of
/// voxels with which at most kFieldCells cells per axis suffice.
FieldGrid placeField(const Carver& carver, const Vec3& center, const Vec3& half_size_m);

class DistanceField {
 public:
  explicit DistanceField(Gpu& gpu);
  /// Records the distances to the carver's model over `grid`.
  void record(Recorder& recorder, const Carver& carver, const FieldGrid& grid);
  /// In the format of distance_io.h, ordered by FieldGrid::index().
  const Buffer<std::uint64_t>& entries() const { return entries_; }
  /// Metres, positive outside. Exact up to kFieldReach cells outside and kFieldInnerReach cells inside. \pre
  /// the recorded work is done
  std::vector<float> download(const FieldGrid& grid) const;

 private:
  Kernel<DistanceRowArgs> voxel_rows_, cell_rows_;
  Kernel<DistanceLineArgs> y_lines_, z_lines_;
  Buffer<std::uint64_t> along_x_, along_y_, entries_;
};

/// The reference implementation: brute force over the cells within reach, in double precision.
std::vector<double> distanceReference(const VoxelGrid& model, const FieldGrid& grid);

/// Trilinear interpolation of a field, metres; outside the box, the value at the border. `point`: workspace
/// frame.
double fieldDistance(const std::vector<double>& field, const FieldGrid& grid, const Vec3& point);

}  // namespace airclay
