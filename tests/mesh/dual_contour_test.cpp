// SPDX-License-Identifier: MIT
// Lattice crossings and dual contouring on degenerate, noisy and known solids.
#include "engine/mesh/dual_contour.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "engine/mesh/manifold.h"
#include "engine/mesh/outer_surface.h"
#include "engine/mesh/thicken.h"
#include "tests/support/solids.h"

namespace airclay {
namespace {

Eigen::AlignedBox3d boxOf(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vec3& vertex : mesh.vertices) box.extend(vertex);
  return box;
}

PolygonMesh cageOf(const QuadNet& net) {
  PolygonMesh cage{net.points, {}};
  for (const auto& quad : net.quads) cage.faces.emplace_back(quad.begin(), quad.end());
  return cage;
}

/// A closed 2-manifold without border.
void expectClosed(const QuadNet& net) {
  const PolygonMesh cage = cageOf(net);
  EXPECT_NO_THROW(checkCage(cage, "net"));
  EXPECT_EQ(openEdges([&] {
              TriangleMesh mesh{net.points, {}};
              for (const auto& [a, b, c, d] : net.quads) {
                mesh.triangles.push_back({a, b, c});
                mesh.triangles.push_back({a, c, d});
              }
              return mesh;
            }()),
            0u);
}

void expectWindingsWithin(const TriangleMesh& mesh, const Lattice& lattice, int lowest, int highest) {
  for (int axis = 0; axis < 3; ++axis) {
    const LatticeCrossings crossings(mesh, lattice, axis);
    std::size_t count = 0;
    for (std::size_t line = 0; line < crossings.lineCount(); ++line) {
      int winding = 0;
      for (const Crossing& crossing : crossings.line(line)) {
        winding += crossing.step;
        ASSERT_GE(winding, lowest);
        ASSERT_LE(winding, highest);
        ++count;
      }
      ASSERT_EQ(winding, 0);
    }
    EXPECT_GT(count, 10u);
  }
}

// Faces and edges in the lattice's planes, diagonals through its points.
TEST(LatticeCrossings, WindingReturnsToZeroOnDegenerateLines) {
  const Lattice lattice{Vec3(-4, -4, -4), 1, {9, 9, 9}};
  expectWindingsWithin(boxMesh(Vec3(2, 2, 2)), lattice, 0, 1);
  expectWindingsWithin(boxMesh(Vec3(2.5, 1, 3)), lattice, 0, 1);
  expectWindingsWithin(ballMesh(Vec3::Zero(), 3, 2), lattice, 0, 1);
}

TEST(LatticeCrossings, OverlapHasWindingTwo) {
  TriangleMesh moved = boxMesh(Vec3(1, 1, 1));
  for (Vec3& vertex : moved.vertices) vertex += Vec3(1, 0.5, 0);
  const TriangleMesh both = together(boxMesh(Vec3(1, 1, 1)), moved);
  expectWindingsWithin(both, latticeAround(boxOf(both), 0.1), 0, 2);
  const SolidStructure structure = solidStructure(both, latticeAround(boxOf(both), 0.02));
  EXPECT_EQ(structure.groups, 1);
  EXPECT_TRUE(structure.overlaps[0]);
  EXPECT_NEAR(structure.volume_m3, 8 + 8 - 1 * 1.5 * 2, 0.15);  // columns of a fiftieth, steps at the sides
}

TEST(LatticeCrossings, PartsOverlapEncloseOrStaySeparate) {
  const TriangleMesh ball = ballMesh(Vec3::Zero(), 1, 4);
  TriangleMesh cavity = ballMesh(Vec3::Zero(), 0.5, 4);
  for (auto& triangle : cavity.triangles) std::swap(triangle[0], triangle[1]);
  const TriangleMesh hollow = together(ball, cavity);
  const SolidStructure enclosed = solidStructure(hollow, latticeAround(boxOf(hollow), 0.02));
  EXPECT_EQ(enclosed.groups, 1);
  EXPECT_FALSE(enclosed.overlaps[0]);
  EXPECT_NEAR(enclosed.volume_m3, 4 * std::numbers::pi / 3 * (1 - 0.125), 0.005);
  const TriangleMesh pair = together(ball, ballMesh(Vec3(2.01, 0, 0), 1, 4));
  const SolidStructure separate = solidStructure(pair, latticeAround(boxOf(pair), 0.05));
  EXPECT_EQ(separate.groups, 2);
  EXPECT_NE(separate.group_of_triangle.front(), separate.group_of_triangle.back());
}

TEST(DualContour, FindsEdgesAndCornersOfABox) {
  const Vec3 half(0.031, 0.022, 0.043);
  const double spacing = 0.0047;
  const TriangleMesh box = boxMesh(half);
  const QuadNet net = dualContour(box, latticeAround(boxOf(box), spacing));
  expectClosed(net);
  int corners = 0;
  for (std::size_t v = 0; v < net.points.size(); ++v) {
    const Vec3 beyond = net.points[v].cwiseAbs() - half;
    EXPECT_LT(beyond.maxCoeff(), 1e-9);
    int near_sides = 0;
    for (const double side : beyond) near_sides += std::abs(side) < spacing;
    EXPECT_GE(near_sides, 1 + int(net.features[v]));
    if (net.features[v] == Feature::kSmooth) {
      EXPECT_NEAR(beyond.maxCoeff(), 0, 1e-9);
    }
    corners += net.features[v] == Feature::kCorner;
  }
  EXPECT_EQ(corners, 8);
}

TEST(MeetingPoint, IsWhereThePlanesMeet) {
  const std::vector<TangentPlane> planes = {
      {Vec3(1, 5, 7), Vec3::UnitX()}, {Vec3(8, 2, 3), Vec3::UnitY()}, {Vec3(4, 9, 3), Vec3(0.6, 0, 0.8)}};
  Feature feature = Feature::kSmooth;
  EXPECT_LT((meetingPoint(planes, Vec3(0, 0, 0), feature) - Vec3(1, 2, 5.25)).norm(), 1e-12);
  EXPECT_EQ(feature, Feature::kCorner);
  EXPECT_LT((meetingPoint(std::span(planes).first(2), Vec3(0, 0, 9), feature) - Vec3(1, 2, 9)).norm(), 1e-12);
  EXPECT_EQ(feature, Feature::kCrease);
  EXPECT_LT((meetingPoint(std::span(planes).first(1), Vec3(0, 8, 9), feature) - Vec3(1, 8, 9)).norm(), 1e-12);
  EXPECT_EQ(feature, Feature::kSmooth);
}

// Hundreds of overlapping balls about as large as a cell: every configuration of a cell's signs occurs.
TEST(DualContour, NoiseIsManifold) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(-0.06, 0.06), size(0.003, 0.008);
    TriangleMesh noise;
    for (int i = 0; i < 900; ++i)
      noise = together(noise, ballMesh(Vec3(place(random), place(random), place(random)), size(random), 1));
    QuadNet net = dualContour(noise, latticeAround(boxOf(noise), 0.01));
    ASSERT_GT(net.quads.size(), 1000u);
    expectClosed(net);
    const int euler = eulerCharacteristic(cageOf(net));
    collapseRhombi(net);
    expectClosed(net);
    EXPECT_EQ(eulerCharacteristic(cageOf(net)), euler);
  }
}

TEST(CollapseRhombi, MakesMostPointsRegular) {
  const TriangleMesh ball = ballMesh(Vec3::Zero(), 0.05, 5);
  QuadNet net = dualContour(ball, latticeAround(boxOf(ball), 0.003));
  const auto irregular = [&] {
    std::vector<int> valences(net.points.size());
    for (const auto& quad : net.quads)
      for (const int corner : quad) ++valences[std::size_t(corner)];
    return double(std::count_if(valences.begin(), valences.end(), [](int n) { return n != 4; })) /
           double(valences.size());
  };
  const double before = irregular();
  const std::size_t quads = net.quads.size();
  collapseRhombi(net);
  expectClosed(net);
  EXPECT_EQ(eulerCharacteristic(cageOf(net)), 2);
  EXPECT_LT(net.quads.size(), quads);
  EXPECT_LT(irregular(), 0.7 * before);
}

TEST(OuterSurface, DropsWhatIsInside) {
  const double radius = 0.05, apart = 0.06, detail = 0.004;
  const TriangleMesh both =
      together(ballMesh(Vec3::Zero(), radius, 5), ballMesh(Vec3(apart, 0, 0), radius, 5));
  double area = 0;
  for (const Triangle& t : outerTriangles(both, detail)) {
    for (const Vec3& corner : t)
      EXPECT_GT(std::min(corner.norm(), (corner - Vec3(apart, 0, 0)).norm()), radius - detail / 4);
    area += (t[1] - t[0]).cross(t[2] - t[0]).norm() / 2;
  }
  // two caps of the height radius + apart / 2
  EXPECT_NEAR(area / (4 * std::numbers::pi * radius * (radius + apart / 2)), 1, 0.01);
}

TEST(Thicken, SheetBecomesSlab) {
  TriangleMesh sheet;
  sheet.vertices = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  const TriangleMesh slab = thickened(sheet, 0.25);
  EXPECT_EQ(openEdges(sheet), 4u);
  EXPECT_EQ(openEdges(slab), 0u);
  EXPECT_NEAR(massProperties(slab).volume_m3, 0.5, 1e-12);
}

}  // namespace
}  // namespace airclay
