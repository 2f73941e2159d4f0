// SPDX-License-Identifier: MIT
#include "engine/hull/hull_mesh.h"

#include <cmath>
#include <map>

#include "tests/support/gpu_fixture.h"
#include "tests/support/scene.h"

namespace airclay {
namespace {

/// Every edge has one triangle on each side.
void expectClosed(const TriangleMesh& mesh) {
  std::map<std::pair<int, int>, int> sides;  // from, to: number of triangles along the edge in that direction
  for (const auto& [a, b, c] : mesh.triangles)
    for (const auto& edge : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) ++sides[edge];
  std::size_t unpaired = 0;
  for (const auto& [edge, count] : sides) {
    const auto other = sides.find({edge.second, edge.first});
    unpaired += other == sides.end() || other->second != count;
  }
  EXPECT_EQ(unpaired, 0u);
}

double voxelVolume(const VoxelGrid& grid, const Workspace& workspace) {
  const double voxel_m = workspace.edge_m / grid.voxels;
  return std::pow(voxel_m, 3) * static_cast<double>(hullStats(grid, workspace).occupied);
}

TEST(HullMesh, HasTheVolumeAndPositionOfTheVoxels) {
  Rig rig = ringRig(6);
  rig.workspace = {Vec3(0.02, 0.01, -0.015), 0.5};
  const VoxelGrid grid = carve(testGpu(), rig, sphereMasks(rig, Vec3(0.05, -0.03, 0.02), 0.09), 96);
  const TriangleMesh mesh = hullMesh(grid, rig.workspace);
  const MassProperties solid = massProperties(mesh);
  EXPECT_NEAR(solid.volume_m3 / voxelVolume(grid, rig.workspace), 1, 0.01);
  EXPECT_LT((solid.centroid - hullStats(grid, rig.workspace).centroid).norm(), 0.2e-3);
  expectClosed(mesh);
}

TEST(HullMesh, CarveEqualsTheReference) {
  const Rig rig = ringRig(4);
  const std::vector<Silhouette> masks = sphereMasks(rig, Vec3(-0.04, 0.03, 0), 0.07);
  const VoxelGrid carved = carve(testGpu(), rig, masks, 64), expected = carveReference(rig, masks, 64);
  const std::vector<std::uint8_t> edge = edgeVoxels(rig, masks, 64, kEdgePixels);
  std::size_t different = 0;
  for (std::size_t i = 0; i < edge.size(); ++i)
    different += !edge[i] && carved.occupied[i] != expected.occupied[i];
  EXPECT_EQ(different, 0u);
  EXPECT_GT(hullStats(carved, rig.workspace).occupied, 1000u);
}

TEST(HullMesh, FullWorkspaceGivesAClosedMesh) {
  const VoxelGrid full{32, std::vector<std::uint8_t>(32 * 32 * 32, 1)};
  const Workspace workspace{Vec3(1, 2, 3), 0.32};
  const TriangleMesh mesh = hullMesh(full, workspace);
  expectClosed(mesh);
  EXPECT_NEAR(massProperties(mesh).volume_m3, std::pow(0.32, 3), 0.02 * std::pow(0.32, 3));
  EXPECT_LT((massProperties(mesh).centroid - workspace.center).norm(), 1e-3);
}

TEST(HullMesh, EmptyHullGivesAnEmptyMesh) {
  const TriangleMesh mesh = hullMesh({32, std::vector<std::uint8_t>(32 * 32 * 32)}, {});
  EXPECT_TRUE(mesh.vertices.empty());
  EXPECT_TRUE(mesh.triangles.empty());
}

}  // namespace
}  // namespace airclay
