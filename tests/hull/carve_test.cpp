// SPDX-License-Identifier: MIT
#include "engine/hull/carve.h"

#include "engine/core/error.h"
#include "tests/support/gpu_fixture.h"
#include "tests/support/scene.h"

namespace airclay {
namespace {

VoxelGrid carve(const Rig& rig, const std::vector<Silhouette>& masks, int voxels,
                HullStats* counted = nullptr, std::uint32_t missing_cameras = 0) {
  Gpu& gpu = testGpu();
  const GpuRig gpu_rig(gpu, rig);
  Buffer<std::uint32_t> packed(gpu, gpu_rig.maskWords(), Memory::kHost);
  gpu_rig.pack(masks, packed.host());
  Carver carver(gpu, gpu_rig, voxels);
  Recorder recorder(gpu);
  // twice: the first frame must not affect the second
  for (int frame = 0; frame < 2; ++frame) {
    recorder.begin();
    recorder.stage("carve");
    carver.record(recorder, packed, missing_cameras);
    recorder.submitAndWait();
  }
  EXPECT_TRUE(hazards(recorder.commands()).empty());
  if (counted) *counted = carver.stats();
  return carver.download();
}

/// Equal except for edge voxels; returns the number of occupied ones.
std::size_t expectEqual(const Rig& rig, const std::vector<Silhouette>& masks, int voxels) {
  const VoxelGrid expected = carveReference(rig, masks, voxels);
  const VoxelGrid carved = carve(rig, masks, voxels);
  const std::vector<std::uint8_t> edge = edgeVoxels(rig, masks, voxels, kEdgePixels);
  std::size_t different = 0, occupied = 0, exempt = 0;
  for (std::size_t i = 0; i < expected.occupied.size(); ++i) {
    different += !edge[i] && expected.occupied[i] != carved.occupied[i];
    occupied += expected.occupied[i];
    exempt += edge[i];
  }
  EXPECT_EQ(different, 0u);
  EXPECT_LT(exempt, expected.occupied.size() / 20) << "the exemption must stay an exemption";
  return occupied;
}

TEST(Carve, EqualsTheReferenceForEveryVoxelCount) {
  const Rig rig = ringRig(4);
  const std::vector<Silhouette> masks = sphereMasks(rig, Vec3(0.05, -0.03, 0.02), 0.09);
  for (const int voxels : {32, 50, 64, 101, 128}) {
    SCOPED_TRACE(voxels);
    EXPECT_GT(expectEqual(rig, masks, voxels), 0u);
  }
}

TEST(Carve, IgnoresMissingCameras) {
  const Rig rig = ringRig(4);
  std::vector<Silhouette> masks = sphereMasks(rig, Vec3(0.05, -0.03, 0.02), 0.09);
  std::fill(masks[1].pixels.begin(), masks[1].pixels.end(), std::uint8_t(0));  // would empty the workspace
  Rig others = rig;
  others.cameras.erase(others.cameras.begin() + 1);
  std::vector<Silhouette> their_masks = masks;
  their_masks.erase(their_masks.begin() + 1);
  const VoxelGrid expected = carve(others, their_masks, 64);
  EXPECT_EQ(carve(rig, masks, 64, nullptr, 1u << 1).occupied, expected.occupied);
  EXPECT_GT(std::count(expected.occupied.begin(), expected.occupied.end(), 1), 0);
  // three of four missing: no voxel is seen by two cameras
  const VoxelGrid alone = carve(rig, masks, 64, nullptr, 0b1011);
  EXPECT_EQ(std::count(alone.occupied.begin(), alone.occupied.end(), 0), 64 * 64 * 64);
}

TEST(Carve, SphereHullIsTight) {
  const Rig rig = ringRig(8, 640, 480);
  const Vec3 center(0.05, -0.03, 0.02);
  const double radius_m = 0.09;
  HullStats counted;
  const VoxelGrid grid = carve(rig, sphereMasks(rig, center, radius_m), 128, &counted);
  const double voxel_m = rig.workspace.edge_m / 128;
  std::size_t index = 0;
  for (int z = 0; z < 128; ++z)
    for (int y = 0; y < 128; ++y)
      for (int x = 0; x < 128; ++x, ++index) {
        const double distance = (voxelCenter(rig.workspace, 128, x, y, z) - center).norm();
        // a pixel is at most 2.2 mm wide here
        if (distance < radius_m - 0.0022) {
          EXPECT_TRUE(grid.occupied[index]);
        }
        // eight views: the hull's corners stick out by at most a quarter of the radius
        if (distance > 1.25 * radius_m) {
          EXPECT_FALSE(grid.occupied[index]);
        }
      }
  const HullStats figures = hullStats(grid, rig.workspace);
  EXPECT_EQ(counted.occupied, figures.occupied);
  EXPECT_LT((counted.centroid - figures.centroid).norm(), 1e-12);
  EXPECT_LT((figures.centroid - center).norm(), 3 * voxel_m);
  const double volume = double(figures.occupied) * voxel_m * voxel_m * voxel_m;
  const double sphere = 4.0 / 3 * M_PI * radius_m * radius_m * radius_m;
  EXPECT_GT(volume, 0.98 * sphere);
  EXPECT_LT(volume, 1.15 * sphere);
}

TEST(Carve, FullMasksFillTheWorkspace) {
  const Rig rig = ringRig(4, 640, 480);
  std::vector<Silhouette> masks = sphereMasks(rig, Vec3::Zero(), 10);
  for (Silhouette& mask : masks) std::fill(mask.pixels.begin(), mask.pixels.end(), 255);
  expectEqual(rig, masks, 64);
  // the sums of so many indices exceed 32 bits
  for (const int voxels : {256, 512}) {
    SCOPED_TRACE(voxels);
    HullStats counted;
    const VoxelGrid grid = carve(rig, masks, voxels, &counted);
    const HullStats figures = hullStats(grid, rig.workspace);
    EXPECT_GT(counted.occupied, std::pow(voxels, 3) / 2);
    EXPECT_EQ(counted.occupied, figures.occupied);
    EXPECT_LT((counted.centroid - figures.centroid).norm(), 1e-12);
  }
}

TEST(Carve, EmptyMasksGiveAnEmptyHull) {
  const Rig rig = ringRig(4);
  std::vector<Silhouette> masks = sphereMasks(rig, Vec3(10, 10, 10), 0.01);
  HullStats counted;
  const VoxelGrid grid = carve(rig, masks, 64, &counted);
  EXPECT_EQ(counted.occupied, hullStats(grid, rig.workspace).occupied);
  expectEqual(rig, masks, 64);
}

TEST(Carve, ProbabilitiesOfHalfAndAboveAreTheHand) {
  const Rig rig = ringRig(4);
  const std::vector<Silhouette> masks = sphereMasks(rig, Vec3(0.05, -0.03, 0.02), 0.09);
  std::vector<Silhouette> probabilities = masks;
  std::size_t i = 0;
  for (Silhouette& silhouette : probabilities)
    for (std::uint8_t& pixel : silhouette.pixels)
      pixel = static_cast<std::uint8_t>(pixel == 0 ? i++ % 128 : 128 + i++ % 128);
  EXPECT_GT(expectEqual(rig, probabilities, 64), 0u);
  EXPECT_EQ(carve(rig, probabilities, 64).occupied, carve(rig, masks, 64).occupied);
}

TEST(Carve, IgnoresCamerasThatDoNotSeeAVoxel) {
  // a fifth camera, close by, sees only a corner of the workspace
  Rig rig = ringRig(5);
  rig.cameras[4].lens.fx *= 6;
  rig.cameras[4].lens.fy *= 6;
  expectEqual(rig, sphereMasks(rig, Vec3(0.12, 0.1, -0.05), 0.1), 64);
}

TEST(Carve, FewerThanTwoViewsGiveAnEmptyHull) {
  Rig rig = ringRig(2);
  rig.cameras[1].camera_from_world.linear() =
      Eigen::AngleAxisd(M_PI, Vec3::UnitY()) * rig.cameras[1].camera_from_world.linear();
  rig.cameras[1].camera_from_world.translation() = Vec3(0, 0, -1);  // the workspace is behind it
  std::vector<Silhouette> masks = sphereMasks(rig, Vec3::Zero(), 0.1);
  EXPECT_EQ(expectEqual(rig, masks, 64), 0u);
}

TEST(Carve, SupportsFisheyeAndRationalLensesAtAnyScale) {
  Rig rig = ringRig(4);
  rig.cameras[0].lens.model = LensModel::kFisheye;
  rig.cameras[0].lens.distortion = {0.05, -0.02, 0.003, -0.001, 0, 0, 0, 0};
  rig.cameras[0].lens.fx = rig.cameras[0].lens.fy = 120;
  rig.cameras[0].lens = withMonotonicRange(rig.cameras[0].lens);
  rig.cameras[1].lens.distortion = {0.3, -0.1, 1e-3, -5e-4, 0.02, 0.25, -0.08, 0.01};
  rig.cameras[1].lens = withMonotonicRange(rig.cameras[1].lens);
  EXPECT_GT(expectEqual(rig, sphereMasks(rig, Vec3(0.05, -0.03, 0.02), 0.09), 96), 0u);

  const double scale = 40;  // a room
  for (Camera& camera : rig.cameras) camera.camera_from_world.translation() *= scale;
  rig.workspace.edge_m *= scale;
  EXPECT_GT(expectEqual(rig, sphereMasks(rig, scale * Vec3(0.05, -0.03, 0.02), scale * 0.09), 96), 0u);
}

TEST(Carve, RejectsInvalidVoxelCount) {
  EXPECT_THROW(checkVoxels(0), Error);
  EXPECT_THROW(checkVoxels(1'000'000'000), Error);
  EXPECT_THROW(checkVoxels(-5), Error);
  EXPECT_NO_THROW(checkVoxels(512));
}

}  // namespace
}  // namespace airclay
