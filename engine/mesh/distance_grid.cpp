// SPDX-License-Identifier: MIT
// Signed distances to a closed triangle mesh: the nearest point and the winding number by the same hierarchy.
#include "engine/mesh/distance_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/core/error.h"
#include "engine/core/parallel.h"
#include "engine/mesh/triangle_tree.h"

namespace airclay {
namespace {

constexpr double kMaxSamples = 256e6;  // 1 GB; more indicates a mistyped cell size

/// Fills one row of samples along x. Between samples the distance changes at most by their spacing, which
/// bounds the search; if both are farther from the surface than that, they are on the same side.
void fillRow(const TriangleTree& hierarchy, DistanceGrid& grid, int j, int k) {
  const double largest = std::numeric_limits<double>::max();
  double distance = std::sqrt(largest), sign = 0;
  for (int i = 0; i < grid.size[0]; ++i) {
    const Vec3 point = grid.low_corner + grid.cell_m * Vec3(i, j, k);
    const double before = distance;
    const double bound = i == 0 ? std::sqrt(largest) : before + 1.001 * grid.cell_m;
    distance = hierarchy.distance(point, bound);
    if (sign == 0 || before + distance <= 1.001 * grid.cell_m)
      sign = hierarchy.windingNumber(point) > 0.5 ? -1 : 1;
    grid.values[size_t(i) + size_t(grid.size[0]) * (size_t(j) + size_t(grid.size[1]) * k)] =
        float(sign * distance);
  }
}

}  // namespace

DistanceGrid signedDistanceGrid(const TriangleMesh& mesh, double cell_m, double margin_m) {
  const TriangleMesh closed = withCaps(mesh);
  if (closed.triangles.empty())
    throw Error("distance grid: the mesh has no triangles; expected the surface of a solid");
  const TriangleTree hierarchy(cornersOf(closed));
  DistanceGrid grid;
  grid.cell_m = cell_m;
  const Vec3 extent = hierarchy.box().sizes() + Vec3::Constant(2 * margin_m);
  const Vec3 cells = (extent / cell_m).array().ceil();
  const double samples = (cells + Vec3::Ones()).prod();
  if (!(cell_m > 0 && margin_m >= 0 && samples <= kMaxSamples))
    throw Error("distance grid: cells of " + std::to_string(cell_m) + " m around a mesh of " +
                std::to_string(extent.maxCoeff()) + " m; expected at most 256 million samples");
  for (int axis = 0; axis < 3; ++axis) grid.size[axis] = int(cells[axis]) + 1;
  grid.low_corner = hierarchy.box().center() - cells * cell_m / 2;
  grid.values.resize(size_t(samples));

  parallelFor(size_t(grid.size[2]), 1, [&](size_t first, size_t last) {
    for (size_t k = first; k < last; ++k)
      for (int j = 0; j < grid.size[1]; ++j) fillRow(hierarchy, grid, j, int(k));
  });
  return grid;
}

double sample(const DistanceGrid& grid, const Vec3& point) {
  const Vec3 last(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1);
  const Vec3 in_cells = (point - grid.low_corner) / grid.cell_m;
  const Vec3 clamped = in_cells.cwiseMax(Vec3::Zero()).cwiseMin(last);
  std::array<size_t, 3> low{};
  Vec3 fraction;
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = size_t(std::clamp(std::floor(clamped[axis]), 0., std::max(last[axis] - 1, 0.)));
    fraction[axis] = clamped[axis] - double(low[axis]);
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    std::array<size_t, 3> at = low;
    for (int axis = 0; axis < 3; ++axis) {
      const bool high = (corner >> axis) & 1;
      weight *= high ? fraction[axis] : 1 - fraction[axis];
      at[axis] += high;
    }
    if (weight > 0)
      sum += weight * grid.values[at[0] + size_t(grid.size[0]) * (at[1] + size_t(grid.size[1]) * at[2])];
  }
  return sum + (in_cells - clamped).norm() * grid.cell_m;
}

double signedDistance(const TriangleMesh& mesh, const Vec3& point) {
  double nearest = std::numeric_limits<double>::infinity(), winding = 0;
  for (const auto& triangle : cornersOf(withCaps(mesh))) {
    nearest = std::min(nearest, (point - nearestOnTriangle(point, triangle)).norm());
    winding += solidAngle(point, triangle) / (4 * std::numbers::pi);
  }
  return winding > 0.5 ? -nearest : nearest;
}

}  // namespace airclay
