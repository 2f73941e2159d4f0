// SPDX-License-Identifier: MIT
#include "engine/distance.h"

#include <algorithm>
#include <cmath>

#include "shaders/distance_lines.comp.h"
#include "shaders/distance_rows.comp.h"

namespace airclay {

FieldGrid placeField(const Carver& carver, const Vec3& center, double reach_m) {
  FieldGrid grid;
  const double voxel_m = carver.voxelMetres();
  grid.place.stride = static_cast<std::uint32_t>(std::max(1.0, std::ceil(2 * reach_m / (voxel_m * kFieldCells))));
  grid.cell_m = voxel_m * grid.place.stride;
  for (int k = 0; k < 3; ++k) {
    const double low_m = center[k] - 0.5 * grid.cell_m * kFieldCells + 0.5 * voxel_m * carver.voxels();
    grid.place.low[k] = static_cast<int>(std::lround(low_m / voxel_m));
    // the voxel in the cell's middle stands for it
    grid.low[k] = voxel_m * (grid.place.low[k] + int(grid.place.stride / 2) + 0.5 - 0.5 * carver.voxels());
  }
  return grid;
}

DistanceField::DistanceField(Gpu& gpu)
    : rows_(gpu, "distance_rows", distance_rows_comp, {kFieldWorkgroup}),
      lines_(gpu, "distance_lines", distance_lines_comp, {kFieldWorkgroup}),
      along_x_(gpu, kFieldSize),
      along_y_(gpu, kFieldSize),
      distances_(gpu, kFieldSize) {}

void DistanceField::record(Recorder& recorder, const Carver& carver, const FieldGrid& grid) {
  DistanceRowArgs rows{};
  rows.brick_states = carver.brickStates();
  rows.words = carver.words();
  rows.squares = along_x_;
  rows.place = grid.place;
  rows.voxels = static_cast<std::uint32_t>(carver.voxels());
  recorder.dispatch(rows_, rows, kFieldCells * kFieldCells / kFieldWorkgroup);

  DistanceLineArgs lines{};
  lines.cell_m = static_cast<float>(grid.cell_m);
  lines.squares = along_x_;
  lines.next_squares = along_y_;
  lines.axis_step = kFieldCells;
  recorder.dispatch(lines_, lines, kFieldSize / kFieldWorkgroup);
  lines.squares = along_y_;
  lines.next_squares = {};
  lines.distances = distances_;
  lines.axis_step = kFieldCells * kFieldCells;
  recorder.dispatch(lines_, lines, kFieldSize / kFieldWorkgroup);
}

}  // namespace airclay
