// SPDX-License-Identifier: MIT
#include "engine/hull/distance.h"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

#include "engine/synthetic/demo_scene.h"
#include "tests/support/gpu_fixture.h"
#include "tests/support/scene.h"

namespace airclay {
namespace {

/// A carved model and its distances from the kernels.
struct Field {
  GpuRig rig;
  Carver carver;
  DistanceField field;
  Recorder recorder;
  VoxelGrid model;

  Field(const Rig& r, const std::vector<Silhouette>& masks, int voxels)
      : rig(testGpu(), r), carver(testGpu(), rig, voxels), field(testGpu()), recorder(testGpu()) {
    Buffer<std::uint32_t> packed(testGpu(), rig.maskWords(), Memory::kHost);
    rig.pack(masks, packed.host());
    recorder.begin();
    carver.record(recorder, packed);
    recorder.submitAndWait();
    model = carver.download();
  }

  FieldGrid place(const Vec3& center, const Vec3& half_size_m) const {
    return placeField(carver, center, half_size_m);
  }
  std::vector<float> distances(const FieldGrid& grid) {
    recorder.begin();
    field.record(recorder, carver, grid);
    recorder.submitAndWait();
    EXPECT_TRUE(hazards(recorder.commands()).empty());
    return field.download(grid);
  }
};

std::vector<Silhouette> fullMasks(const Rig& rig) {
  std::vector<Silhouette> masks;
  for (const Camera& camera : rig.cameras)
    masks.push_back({camera.width, camera.height,
                     std::vector<std::uint8_t>(std::size_t(camera.width) * camera.height, 255)});
  return masks;
}

/// Images with random holes: a model of intersecting cones, with every kind of corner.
std::vector<Silhouette> masksWithHoles(const Rig& rig, unsigned seed) {
  std::mt19937 random(seed);
  const auto below = [&](int limit) { return int(random() % unsigned(limit)); };
  std::vector<Silhouette> masks = fullMasks(rig);
  for (Silhouette& mask : masks)
    for (int hole = 0; hole < 30; ++hole) {
      const int u = below(mask.width), v = below(mask.height), radius = 2 + below(mask.width / 16);
      for (int y = std::max(v - radius, 0); y < std::min(v + radius, mask.height); ++y)
        for (int x = std::max(u - radius, 0); x < std::min(u + radius, mask.width); ++x)
          if ((x - u) * (x - u) + (y - v) * (y - v) < radius * radius)
            mask.pixels[std::size_t(y) * mask.width + x] = 0;
    }
  return masks;
}

/// The kernels compared with the reference: equal squared integer distances, and a float's rounding.
void expectReference(Field& field, const FieldGrid& grid) {
  const std::vector<float> found = field.distances(grid);
  const std::vector<double> expected = distanceReference(field.model, grid);
  ASSERT_EQ(found.size(), expected.size());
  std::size_t different = 0, inside = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    different += !(std::abs(found[i] - expected[i]) <= 1e-6 * grid.cell_m);
    inside += expected[i] < 0;
  }
  EXPECT_EQ(different, 0u) << "of " << found.size();
  EXPECT_GT(inside, 300u) << "there must be something to measure";
  EXPECT_GT(found.size() - inside, 300u);
}

TEST(Distance, EqualsTheReferenceForAnyBox) {
  const Rig rig = ringRig(4);
  for (const int voxels : {128, 101, 50}) {
    SCOPED_TRACE(std::to_string(voxels) + " voxels");
    Field field(rig, masksWithHoles(rig, 5), voxels);
    const double voxel_m = field.carver.voxelMetres();
    for (const Vec3& center : {Vec3(0.03, -0.05, 0.02), Vec3(-0.28, 0.26, 0.27)}) {
      SCOPED_TRACE(center.transpose());
      for (const double half_voxels : {27.0, 44.0, 90.0}) {  // cells of one, two and more voxels
        SCOPED_TRACE(half_voxels);
        const FieldGrid grid =
            field.place(center, voxel_m * Vec3(half_voxels, 0.6 * half_voxels, 0.8 * half_voxels));
        EXPECT_EQ(grid.place.stride, half_voxels < 28 ? 1u : half_voxels < 60 ? 2u : 3u);
        expectReference(field, grid);
      }
    }
  }
}

TEST(Distance, BoxContainsTheRequestedRegion) {
  const Rig rig = ringRig(4);
  const Field field(rig, fullMasks(rig), 128);
  std::mt19937 random(9);
  std::uniform_real_distribution<double> place(-0.3, 0.3), size(0.01, 0.5);
  for (int i = 0; i < 200; ++i) {
    const Vec3 center(place(random), place(random), place(random)),
        half(size(random), size(random), size(random));
    const FieldGrid grid = field.place(center, half);
    EXPECT_DOUBLE_EQ(grid.cell_m, grid.place.stride * field.carver.voxelMetres());
    for (int k = 0; k < 3; ++k) {
      EXPECT_LE(grid.place.size[k], kFieldCells);
      EXPECT_LE(grid.low[k], center[k] - half[k] + grid.cell_m);
      EXPECT_GE(grid.low[k] + grid.cell_m * (grid.place.size[k] - 1), center[k] + half[k] - grid.cell_m);
      // the cell's centre is the centre of the voxel that represents it
      const int voxel = grid.place.low[k] + int(grid.place.stride / 2);
      EXPECT_NEAR(grid.low[k], (voxel + 0.5 - 64) * field.carver.voxelMetres(), 1e-12);
    }
  }
}

TEST(Distance, FullCubeEqualsBoxDistance) {
  constexpr int voxels = 64;
  const Rig rig = demoRig();  // it sees the whole workspace
  Field field(rig, fullMasks(rig), voxels);
  // around a corner of the workspace
  const FieldGrid grid = field.place(Vec3(-0.3, 0.3, -0.3), Vec3::Constant(0.24));
  ASSERT_EQ(grid.place.stride, 1u);
  const std::vector<float> distances = field.distances(grid);
  // cells closer to the box's border may have their nearest cell outside the box
  const int border = kFieldReach;
  int outside = 0, inside = 0;
  for (int z = border; z < int(grid.place.size[2]) - border; ++z)
    for (int y = border; y < int(grid.place.size[1]) - border; ++y)
      for (int x = border; x < int(grid.place.size[0]) - border; ++x) {
        const int v[3] = {x + grid.place.low[0], y + grid.place.low[1], z + grid.place.low[2]};
        double square = 0, depth = kFieldInnerReach;
        for (const int i : v) {
          const int beyond = std::max({0, -i, i - (voxels - 1)});
          square += beyond * beyond;
          depth = std::min<double>(depth, std::min(i + 1, voxels - i));
        }
        const double expected =
            square > 0 ? std::min(std::sqrt(square), double(kFieldReach)) - 0.5 : 0.5 - depth;
        EXPECT_NEAR(distances[grid.index(x, y, z)] / grid.cell_m, expected, 1e-5)
            << x << " " << y << " " << z;
        ++(square > 0 ? outside : inside);
      }
  EXPECT_GT(outside, 1000);
  EXPECT_GT(inside, 1000);
}

TEST(Distance, SphereEqualsCentreDistanceMinusRadius) {
  const Rig rig = ringRig(8, 640, 480);
  const Vec3 center(0.05, -0.03, 0.02);
  const double radius_m = 0.09;
  Field field(rig, sphereMasks(rig, center, radius_m), 128);
  const FieldGrid grid = field.place(center, Vec3::Constant(0.125));
  ASSERT_EQ(grid.place.stride, 1u);
  const std::vector<float> distances = field.distances(grid);
  double sum = 0;
  int count = 0;
  for (int z = 0; z < int(grid.place.size[2]); ++z)
    for (int y = 0; y < int(grid.place.size[1]); ++y)
      for (int x = 0; x < int(grid.place.size[0]); ++x) {
        const double to_center = (grid.low + grid.cell_m * Vec3(x, y, z) - center).norm();
        const double found = distances[grid.index(x, y, z)];
        if (to_center - radius_m > (kFieldReach - 2) * grid.cell_m) continue;
        if (to_center < radius_m - grid.cell_m) {
          EXPECT_LT(found, 0);
        }
        if (to_center < radius_m) continue;
        // the hull contains the sphere, and its corners protrude by at most a quarter of the radius
        // (carve_test); rounding adds at most a voxel's diagonal
        EXPECT_LT(found, to_center - radius_m + 0.9 * grid.cell_m);
        EXPECT_GT(found, to_center - 1.25 * radius_m - 0.9 * grid.cell_m);
        sum += found - (to_center - radius_m);
        ++count;
      }
  ASSERT_GT(count, 10'000);
  // eight views leave a shell of a few millimetres on average
  EXPECT_LT(std::abs(sum / count), 0.005);
}

/// Distances in cells, within a slice, to the nearest cell that is `kind`, by OpenCV; very large if the slice
/// has none.
std::vector<cv::Mat> sliceDistances(const VoxelGrid& model, const FieldGrid& grid, bool kind) {
  std::vector<cv::Mat> slices;
  for (int z = 0; z < int(grid.place.size[2]); ++z) {
    cv::Mat other(int(grid.place.size[1]), int(grid.place.size[0]), CV_8U);
    for (int y = 0; y < other.rows; ++y)
      for (int x = 0; x < other.cols; ++x)
        other.at<std::uint8_t>(y, x) =
            bool(model.at(x + grid.place.low[0], y + grid.place.low[1], z + grid.place.low[2])) != kind;
    cv::Mat distances(other.size(), CV_32F, 1e6f);
    if (cv::countNonZero(other) < other.rows * other.cols)
      cv::distanceTransform(other, distances, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    slices.push_back(distances);
  }
  return slices;
}

TEST(Distance, SlicesEqualOpenCv) {
  const Rig rig = ringRig(4);
  Field field(rig, masksWithHoles(rig, 6), 128);
  const FieldGrid grid = field.place(Vec3(0.02, -0.03, 0), Vec3(0.12, 0.1, 0.08));
  ASSERT_EQ(grid.place.stride, 1u);
  const std::vector<float> distances = field.distances(grid);
  const std::vector<cv::Mat> to_full = sliceDistances(field.model, grid, true),
                             to_empty = sliceDistances(field.model, grid, false);
  const int size_z = int(grid.place.size[2]);
  for (int z = 0; z < size_z; ++z)
    for (int y = 0; y < int(grid.place.size[1]); ++y)
      for (int x = 0; x < int(grid.place.size[0]); ++x) {
        // Pythagoras across the slices
        double full = 1e12, empty = 1e12;
        for (int w = 0; w < size_z; ++w) {
          full = std::min(full, std::pow(to_full[std::size_t(w)].at<float>(y, x), 2) + (w - z) * (w - z));
          empty = std::min(empty, std::pow(to_empty[std::size_t(w)].at<float>(y, x), 2) + (w - z) * (w - z));
        }
        const double expected = full > 0 ? std::min(std::sqrt(full), double(kFieldReach)) - 0.5
                                         : 0.5 - std::min(std::sqrt(empty), double(kFieldInnerReach));
        ASSERT_NEAR(distances[grid.index(x, y, z)] / grid.cell_m, expected, 1e-4)
            << x << " " << y << " " << z;
      }
}

TEST(Distance, InterpolatesLinearlyAndClampsOutside) {
  FieldGrid grid;
  for (std::uint32_t& size : grid.place.size) size = 16;
  grid.cell_m = 0.005;
  grid.low = Vec3(-0.02, 0.01, 0.03);
  const Vec3 slope(2, -3, 0.5);
  std::vector<double> field(grid.cells());
  for (int z = 0; z < 16; ++z)
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 16; ++x)
        field[grid.index(x, y, z)] = slope.dot(grid.low + grid.cell_m * Vec3(x, y, z));
  const Vec3 high = grid.low + 15 * grid.cell_m * Vec3::Ones();
  std::mt19937 random(4);
  std::uniform_real_distribution<double> place(-0.02, 0.1);
  for (int i = 0; i < 200; ++i) {
    const Vec3 point = grid.low + Vec3(place(random), place(random), place(random));
    const Vec3 within = point.cwiseMax(grid.low).cwiseMin(high);
    // the border is a thousandth of a cell before the last cell
    EXPECT_NEAR(fieldDistance(field, grid, point), slope.dot(within),
                1.001e-3 * grid.cell_m * slope.lpNorm<1>());
  }
}

}  // namespace
}  // namespace airclay
