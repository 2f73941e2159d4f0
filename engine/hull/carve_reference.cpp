// SPDX-License-Identifier: MIT
// The reference implementation of the carve kernels: voxel by voxel, in double precision.
#include "engine/hull/carve.h"

namespace airclay {
namespace {

template <class Visit>
void forEachVoxel(const Rig& rig, int voxels, Visit visit) {
  std::size_t index = 0;
  for (int z = 0; z < voxels; ++z)
    for (int y = 0; y < voxels; ++y)
      for (int x = 0; x < voxels; ++x) visit(index++, voxelCenter(rig.workspace, voxels, x, y, z));
}

}  // namespace

VoxelGrid carveReference(const Rig& rig, const std::vector<Silhouette>& masks, int voxels) {
  checkVoxels(voxels);
  VoxelGrid grid{voxels,
                 std::vector<std::uint8_t>(std::size_t(voxels) * std::size_t(voxels) * std::size_t(voxels))};
  forEachVoxel(rig, voxels, [&](std::size_t index, const Vec3& center_in_world) {
    int seen = 0;
    for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
      const std::optional<Vec2> pixel = project(rig.cameras[c], center_in_world);
      if (!pixel) continue;
      ++seen;
      if (!masks[c].contains(static_cast<int>(std::floor(pixel->x() + 0.5)),
                             static_cast<int>(std::floor(pixel->y() + 0.5))))
        return;
    }
    grid.occupied[index] = seen >= 2;
  });
  return grid;
}

bool isEdgePoint(const Rig& rig, const std::vector<Silhouette>& masks, const Vec3& point_in_world,
                 double pixels) {
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const Camera& camera = rig.cameras[c];
    const std::optional<Vec2> pixel =
        projectThroughLens(camera.lens, camera.camera_from_world * point_in_world);
    if (!pixel) continue;
    // 0: background, 1: silhouette, 2: outside the image
    const auto kind = [&](double u, double v) {
      const double x = std::floor(u + 0.5), y = std::floor(v + 0.5);
      if (x < 0 || y < 0 || x >= camera.width || y >= camera.height) return 2;
      return masks[c].contains(static_cast<int>(x), static_cast<int>(y)) ? 1 : 0;
    };
    const int here = kind(pixel->x(), pixel->y());
    for (const double du : {-pixels, pixels})
      for (const double dv : {-pixels, pixels})
        if (kind(pixel->x() + du, pixel->y() + dv) != here) return true;
  }
  return false;
}

std::vector<std::uint8_t> edgeVoxels(const Rig& rig, const std::vector<Silhouette>& masks, int voxels,
                                     double pixels) {
  std::vector<std::uint8_t> edge(std::size_t(voxels) * std::size_t(voxels) * std::size_t(voxels));
  forEachVoxel(rig, voxels, [&](std::size_t index, const Vec3& center_in_world) {
    edge[index] = isEdgePoint(rig, masks, center_in_world, pixels);
  });
  return edge;
}

HullStats hullStats(const VoxelGrid& grid, const Workspace& workspace) {
  HullStats stats;
  std::size_t index = 0;
  Vec3 sum = Vec3::Zero();
  for (int z = 0; z < grid.voxels; ++z)
    for (int y = 0; y < grid.voxels; ++y)
      for (int x = 0; x < grid.voxels; ++x)
        if (grid.occupied[index++]) {
          ++stats.occupied;
          sum += Vec3(x, y, z);
        }
  if (stats.occupied == 0) return stats;
  const double voxel_m = workspace.edge_m / grid.voxels;
  stats.centroid =
      workspace.center + voxel_m * (sum / double(stats.occupied) + Vec3::Constant(0.5 - 0.5 * grid.voxels));
  return stats;
}

}  // namespace airclay
