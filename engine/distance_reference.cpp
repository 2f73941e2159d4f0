// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "engine/distance.h"

namespace airclay {

std::vector<double> distanceReference(const VoxelGrid& model, const FieldGrid& grid) {
  constexpr int n = static_cast<int>(kFieldCells);
  const auto index = [](int x, int y, int z) { return std::size_t(x + n * (y + n * z)); };
  std::vector<char> full(kFieldSize);
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const int stride = static_cast<int>(grid.place.stride);
        const int v[3] = {grid.place.low[0] + stride * x + stride / 2, grid.place.low[1] + stride * y + stride / 2,
                          grid.place.low[2] + stride * z + stride / 2};
        const bool inside = std::all_of(v, v + 3, [&](int i) { return i >= 0 && i < model.voxels; });
        full[index(x, y, z)] = inside && model.at(v[0], v[1], v[2]);
      }
  std::vector<double> field(kFieldSize);
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const bool here = full[index(x, y, z)];
        const int reach = here ? kFieldInnerReach : kFieldReach;
        int nearest = reach * reach;
        for (int w = std::max(z - reach, 0); w <= std::min(z + reach, n - 1); ++w)
          for (int v = std::max(y - reach, 0); v <= std::min(y + reach, n - 1); ++v)
            for (int u = std::max(x - reach, 0); u <= std::min(x + reach, n - 1); ++u)
              if (bool(full[index(u, v, w)]) != here)
                nearest = std::min(nearest, (u - x) * (u - x) + (v - y) * (v - y) + (w - z) * (w - z));
        field[index(x, y, z)] = grid.cell_m * (std::sqrt(double(nearest)) - 0.5) * (here ? -1 : 1);
      }
  return field;
}

double fieldDistance(const std::vector<double>& field, const FieldGrid& grid, const Vec3& point) {
  constexpr int n = static_cast<int>(kFieldCells);
  int low[3];
  double t[3];
  for (int k = 0; k < 3; ++k) {
    // the same border as the kernel's
    const double at = std::clamp((point[k] - grid.low[k]) / grid.cell_m, 0.0, n - 1.001);
    low[k] = static_cast<int>(at);
    t[k] = at - low[k];
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int dx = corner & 1, dy = corner >> 1 & 1, dz = corner >> 2;
    const double weight = (dx ? t[0] : 1 - t[0]) * (dy ? t[1] : 1 - t[1]) * (dz ? t[2] : 1 - t[2]);
    sum += weight * field[std::size_t(low[0] + dx + n * (low[1] + dy + n * (low[2] + dz)))];
  }
  return sum;
}

}  // namespace airclay
