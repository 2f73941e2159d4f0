// SPDX-License-Identifier: MIT
// Signed distance grids compared with closed forms and with the sum over all triangles.
#include "engine/mesh/distance_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "engine/core/error.h"
#include "engine/hand/hand_model.h"
#include "tests/support/solids.h"

namespace airclay {
namespace {

const Vec3 kHalf(0.02, 0.03, 0.05);

TriangleMesh box() {
  return boxMesh(kHalf);
}

double distanceToBox(const Vec3& point) {
  const Vec3 beyond = point.cwiseAbs() - kHalf;
  return beyond.cwiseMax(Vec3::Zero()).norm() + std::min(beyond.maxCoeff(), 0.);
}

template <typename Check>
void forEachSample(const DistanceGrid& grid, const Check& check) {
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i)
        check(Vec3(grid.low_corner + grid.cell_m * Vec3(i, j, k)),
              double(grid.values[size_t(i) + size_t(grid.size[0]) * (size_t(j) + size_t(grid.size[1]) * k)]));
}

TEST(DistanceGrid, BoxEqualsClosedForm) {
  const DistanceGrid grid = signedDistanceGrid(box(), 0.0031, 0.02);
  int inside = 0;
  forEachSample(grid, [&](const Vec3& point, double value) {
    ASSERT_NEAR(value, distanceToBox(point), 1e-8) << point.transpose();  // float's own rounding
    inside += value < 0;
  });
  EXPECT_GT(inside, 1000);
  EXPECT_EQ(grid.values.size(), size_t(grid.size[0]) * grid.size[1] * grid.size[2]);
}

TEST(DistanceGrid, ContainsTheMeshAndItsMargin) {
  const DistanceGrid grid = signedDistanceGrid(box(), 0.003, 0.02);
  const Vec3 cells(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1);
  const Vec3 high_corner = grid.low_corner + grid.cell_m * cells;
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LE(grid.low_corner[axis], -kHalf[axis] - 0.02 + 1e-12);
    EXPECT_GE(grid.low_corner[axis], -kHalf[axis] - 0.02 - grid.cell_m);
    EXPECT_GE(high_corner[axis], kHalf[axis] + 0.02 - 1e-12);
  }
}

TEST(DistanceGrid, OpenBoxEqualsClosedBox) {
  TriangleMesh open = box();
  open.triangles.erase(open.triangles.begin() + 2, open.triangles.begin() + 4);
  forEachSample(signedDistanceGrid(open, 0.004, 0.015), [](const Vec3& point, double value) {
    ASSERT_NEAR(value, distanceToBox(point), 1e-8) << point.transpose();
  });
}

TEST(DistanceGrid, SphereEqualsBallUpToFacets) {
  const double radius = 0.04;
  const TriangleMesh mesh = sphereMesh(radius, 5);
  double sagitta = 0;  // how far facets are below the ball's surface
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 normal =
        (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]).normalized();
    sagitta = std::max(sagitta, radius - normal.dot(mesh.vertices[a]));
  }
  ASSERT_LT(sagitta, 50e-6);
  forEachSample(signedDistanceGrid(mesh, 0.0037, 0.02), [&](const Vec3& point, double value) {
    const double truth = point.norm() - radius;
    ASSERT_GE(value, truth - 1e-8);
    ASSERT_LE(value, truth + sagitta + 1e-8);
  });
}

TEST(DistanceGrid, HandIsExactAtSamples) {
  const HandModel hand = builtInHand(false);
  const DistanceGrid grid = signedDistanceGrid(hand.skin, 0.0025, 0.03);
  std::mt19937 random(7);
  for (int n = 0; n < 1500; ++n) {
    std::array<int, 3> at{};
    for (int axis = 0; axis < 3; ++axis) at[axis] = int(random() % unsigned(grid.size[axis]));
    const Vec3 point = grid.low_corner + grid.cell_m * Vec3(at[0], at[1], at[2]);
    const float value =
        grid.values[size_t(at[0]) + size_t(grid.size[0]) * (size_t(at[1]) + size_t(grid.size[1]) * at[2])];
    ASSERT_NEAR(value, signedDistance(hand.skin, point), 1e-8) << point.transpose();
  }
}

TEST(DistanceGrid, LeftHandMirrorsRightHand) {
  const DistanceGrid right = signedDistanceGrid(builtInHand(false).skin, 0.004, 0.01);
  const DistanceGrid left = signedDistanceGrid(builtInHand(true).skin, 0.004, 0.01);
  ASSERT_EQ(left.size, right.size);
  forEachSample(right, [&](const Vec3& point, double value) {
    ASSERT_NEAR(sample(left, {point.x(), -point.y(), point.z()}), value, 1e-7);
  });
}

TEST(DistanceGrid, IntersectingSheetsShareOneInside) {
  // a box and the same box shifted by half: their union; the overlap has winding number two
  TriangleMesh shifted = box();
  for (Vec3& vertex : shifted.vertices) vertex += Vec3(0.02, 0, 0);
  const TriangleMesh crossed = together(box(), shifted);
  forEachSample(signedDistanceGrid(crossed, 0.0037, 0.01), [](const Vec3& point, double value) {
    const double to_union = std::min(distanceToBox(point), distanceToBox(point - Vec3(0.02, 0, 0)));
    if (std::abs(to_union) > 1e-9) {
      ASSERT_EQ(value < 0, to_union < 0) << point.transpose();
    }
  });
}

TEST(SignedDistance, BoxEqualsClosedForm) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-0.1, 0.1);
  for (int n = 0; n < 2000; ++n) {
    const Vec3 point(place(random), place(random), place(random));
    ASSERT_NEAR(signedDistance(box(), point), distanceToBox(point), 1e-15);
  }
}

TEST(Sample, IsTrilinearInsideAndGrowsOutside) {
  DistanceGrid grid{{1, 2, 3}, 0.5, {3, 4, 2}, {}};
  const auto linear = [](const Vec3& p) {
    return 2 * p.x() - 3 * p.y() + 0.5 * p.z() + p.x() * p.y() * p.z();
  };
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 3; ++i)
        grid.values.push_back(float(linear(grid.low_corner + grid.cell_m * Vec3(i, j, k))));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> fraction(0, 1);
  for (int n = 0; n < 200; ++n) {
    const Vec3 point =
        grid.low_corner + Vec3(fraction(random), 1.5 * fraction(random), 0.5 * fraction(random));
    EXPECT_NEAR(sample(grid, point), linear(point), 1e-5);
  }
  EXPECT_NEAR(sample(grid, {2, 3.5, 3.5}), linear({2, 3.5, 3.5}), 1e-5);  // the last corner
  EXPECT_NEAR(sample(grid, {2 + 3, 3.5 + 4, 3.5}), linear({2, 3.5, 3.5}) + 5, 1e-5);
  EXPECT_NEAR(sample(grid, {0.75, 2.3, 3.1}), linear({1, 2.3, 3.1}) + 0.25, 1e-5);
}

TEST(DistanceGrid, RejectsInvalidCellSize) {
  EXPECT_THROW(signedDistanceGrid(box(), 0, 0.01), Error);
  EXPECT_THROW(signedDistanceGrid(box(), -1, 0.01), Error);
  EXPECT_THROW(signedDistanceGrid(box(), 1e-6, 0.01), Error);
  EXPECT_THROW(signedDistanceGrid(box(), std::nan(""), 0.01), Error);
  EXPECT_THROW(signedDistanceGrid({}, 0.01, 0.01), Error);
}

}  // namespace
}  // namespace airclay
