// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "engine/hull/distance.h"

namespace airclay {

std::vector<double> distanceReference(const VoxelGrid& model, const FieldGrid& grid) {
  const int size[3] = {int(grid.place.size[0]), int(grid.place.size[1]), int(grid.place.size[2])};
  const int stride = static_cast<int>(grid.place.stride);
  std::vector<char> full(grid.cells());
  const auto forEachCell = [&](auto visit) {
    for (int z = 0; z < size[2]; ++z)
      for (int y = 0; y < size[1]; ++y)
        for (int x = 0; x < size[0]; ++x) visit(x, y, z);
  };
  forEachCell([&](int x, int y, int z) {
    const int v[3] = {grid.place.low[0] + stride * x + stride / 2,
                      grid.place.low[1] + stride * y + stride / 2,
                      grid.place.low[2] + stride * z + stride / 2};
    const bool inside = std::all_of(v, v + 3, [&](int i) { return i >= 0 && i < model.voxels; });
    full[grid.index(x, y, z)] = inside && model.at(v[0], v[1], v[2]);
  });
  std::vector<double> field(grid.cells());
  forEachCell([&](int x, int y, int z) {
    const bool here = full[grid.index(x, y, z)];
    const int reach = here ? kFieldInnerReach : kFieldReach;
    int nearest = reach * reach;
    for (int w = std::max(z - reach, 0); w <= std::min(z + reach, size[2] - 1); ++w)
      for (int v = std::max(y - reach, 0); v <= std::min(y + reach, size[1] - 1); ++v)
        for (int u = std::max(x - reach, 0); u <= std::min(x + reach, size[0] - 1); ++u)
          if (bool(full[grid.index(u, v, w)]) != here)
            nearest = std::min(nearest, (u - x) * (u - x) + (v - y) * (v - y) + (w - z) * (w - z));
    field[grid.index(x, y, z)] = grid.cell_m * (std::sqrt(double(nearest)) - 0.5) * (here ? -1 : 1);
  });
  return field;
}

double fieldDistance(const std::vector<double>& field, const FieldGrid& grid, const Vec3& point) {
  int low[3];
  double t[3];
  for (int k = 0; k < 3; ++k) {
    // the same border as in the kernel
    const double at = std::clamp((point[k] - grid.low[k]) / grid.cell_m, 0.0, grid.place.size[k] - 1.001);
    low[k] = static_cast<int>(at);
    t[k] = at - low[k];
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int dx = corner & 1, dy = corner >> 1 & 1, dz = corner >> 2;
    const double weight = (dx ? t[0] : 1 - t[0]) * (dy ? t[1] : 1 - t[1]) * (dz ? t[2] : 1 - t[2]);
    sum += weight * field[grid.index(low[0] + dx, low[1] + dy, low[2] + dz)];
  }
  return sum;
}

}  // namespace airclay
