// SPDX-License-Identifier: MIT
#include "engine/hull/hull_mesh.h"

#include <algorithm>
#include <cmath>

#include "engine/mesh/surface_nets.h"

namespace airclay {
namespace {

using Index = Eigen::Vector3i;

/// The bounding box of the occupied voxels, corners inclusive; empty if there are none.
Eigen::AlignedBox3i occupiedBox(const VoxelGrid& grid) {
  Eigen::AlignedBox3i box;
  for (int z = 0; z < grid.voxels; ++z)
    for (int y = 0; y < grid.voxels; ++y)
      for (int x = 0; x < grid.voxels; ++x)
        if (grid.at(x, y, z)) box.extend(Index(x, y, z));
  return box;
}

double occupancyAt(const VoxelGrid& grid, const Index& voxel) {
  if (voxel.minCoeff() < 0 || voxel.maxCoeff() >= grid.voxels) return 0;
  return grid.at(voxel.x(), voxel.y(), voxel.z());
}

/// Trilinear interpolation between the eight voxels around `point`: in voxels, origin at voxel 0's centre.
double interpolatedOccupancy(const VoxelGrid& grid, const Vec3& point) {
  const Index low = point.array().floor().cast<int>();
  const Vec3 fraction = point - low.cast<double>();
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Index offset(corner & 1, corner >> 1 & 1, corner >> 2);
    const Vec3 weights = offset.cast<double>().cwiseProduct(fraction) +
                         (Index::Ones() - offset).cast<double>().cwiseProduct(Vec3::Ones() - fraction);
    sum += weights.prod() * occupancyAt(grid, low + offset);
  }
  return sum;
}

}  // namespace

TriangleMesh hullMesh(const VoxelGrid& grid, const Workspace& workspace) {
  const Eigen::AlignedBox3i box = occupiedBox(grid);
  if (box.isEmpty()) return {};
  // In voxels; with two extra cells per side, because a surface net must not touch the border of its grid.
  NetGrid net;
  net.low_corner = (box.min() - 2 * Index::Ones()).cast<double>();
  const Index cells = box.max() - box.min() + 4 * Index::Ones();
  net.cells = {cells.x(), cells.y(), cells.z()};
  TriangleMesh mesh =
      surfaceNet([&](const Vec3& point) { return 0.5 - interpolatedOccupancy(grid, point); }, net);
  const double voxel_m = workspace.edge_m / grid.voxels;
  const Vec3 first_centre = voxelCenter(workspace, grid.voxels, 0, 0, 0);
  for (Vec3& vertex : mesh.vertices) vertex = first_centre + voxel_m * vertex;
  return mesh;
}

}  // namespace airclay
