// SPDX-License-Identifier: MIT
#include "engine/hull/distance.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "shaders/hull/distance_lines.comp.h"
#include "shaders/hull/distance_rows.comp.h"

namespace airclay {

FieldGrid placeField(const Carver& carver, const Vec3& center, const Vec3& half_size_m) {
  FieldGrid grid;
  const double voxel_m = carver.voxelMetres();
  // the low corner is aligned to bricks, which costs at most this many voxels
  constexpr double alignment = kBrickVoxels;
  const double reach = 2 * half_size_m.maxCoeff() / voxel_m + alignment;
  grid.place.stride = static_cast<std::uint32_t>(std::max(1.0, std::ceil(reach / kFieldCells)));
  grid.cell_m = voxel_m * grid.place.stride;
  for (int k = 0; k < 3; ++k) {
    const double low = (center[k] - half_size_m[k]) / voxel_m + 0.5 * carver.voxels();
    grid.place.low[k] = static_cast<int>(std::floor(low / alignment) * alignment);
    const double cells = (low - grid.place.low[k] + 2 * half_size_m[k] / voxel_m) / grid.place.stride;
    grid.place.size[k] =
        std::min(kFieldCells, kGroup * static_cast<std::uint32_t>(std::ceil(cells / kGroup)));
    // a cell is represented by the voxel in its middle
    grid.low[k] = voxel_m * (grid.place.low[k] + int(grid.place.stride / 2) + 0.5 - 0.5 * carver.voxels());
  }
  return grid;
}

DistanceField::DistanceField(Gpu& gpu)
    : voxel_rows_(gpu, "distance_rows", distance_rows_comp, {kFieldWorkgroup, 1}),
      cell_rows_(gpu, "distance_rows", distance_rows_comp, {kFieldWorkgroup, 0}),
      y_lines_(gpu, "distance_lines_y", distance_lines_comp, {kFieldWorkgroup, 0}),
      z_lines_(gpu, "distance_lines_z", distance_lines_comp, {kFieldWorkgroup, 1}),
      along_x_(gpu, 2 * kFieldSize / kGroup),
      along_y_(gpu, 2 * kFieldSize / kGroup),
      entries_(gpu, kFieldSize) {}

void DistanceField::record(Recorder& recorder, const Carver& carver, const FieldGrid& grid) {
  const auto& size = grid.place.size;
  DistanceRowArgs rows{};
  rows.brick_states = carver.brickStates();
  rows.words = carver.words();
  rows.squares = along_x_;
  rows.place = grid.place;
  rows.voxels = static_cast<std::uint32_t>(carver.voxels());
  recorder.dispatch(grid.place.stride == 1 ? voxel_rows_ : cell_rows_, rows,
                    groupsFor(size[1] * size[2], kFieldWorkgroup));

  DistanceLineArgs lines{};
  lines.cell_m = static_cast<float>(grid.cell_m);
  lines.groups = static_cast<std::uint32_t>(grid.cells() / kGroup);
  const std::uint32_t workgroups = groupsFor(lines.groups / kFieldRun, kFieldWorkgroup);
  lines.squares = along_x_;
  lines.next_squares = along_y_;
  lines.step = size[0] / kGroup;
  lines.line_cells = size[1];
  recorder.dispatch(y_lines_, lines, workgroups);
  lines.squares = along_y_;
  lines.next_squares = {};
  lines.distances = entries_;
  lines.step = size[0] / kGroup * size[1];
  lines.line_cells = size[2];
  recorder.dispatch(z_lines_, lines, workgroups);
}

std::vector<float> DistanceField::download(const FieldGrid& grid) const {
  const std::vector<std::uint64_t> entries = entries_.download();
  std::vector<float> distances(grid.cells());
  for (std::size_t i = 0; i < distances.size(); ++i) {
    const auto low = static_cast<std::uint32_t>(entries[i]);
    std::memcpy(&distances[i], &low, sizeof low);
  }
  return distances;
}

}  // namespace airclay
