// SPDX-License-Identifier: MIT
// Mass properties, caps and normals compared with closed forms.
#include "engine/mesh/mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

namespace airclay {
namespace {

TriangleMesh box(const Vec3& edges, const Vec3& center) {
  TriangleMesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 side((corner & 1) - 0.5, ((corner >> 1) & 1) - 0.5, ((corner >> 2) & 1) - 0.5);
    mesh.vertices.push_back(center + side.cwiseProduct(edges));
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// Latitudes and longitudes; closed at the poles.
TriangleMesh sphere(double radius, int rings) {
  TriangleMesh mesh;
  const int sectors = 2 * rings;
  mesh.vertices.push_back({0, 0, radius});
  for (int i = 1; i < rings; ++i) {
    for (int j = 0; j < sectors; ++j) {
      const double polar = std::numbers::pi * i / rings, azimuth = 2 * std::numbers::pi * j / sectors;
      mesh.vertices.push_back(radius * Vec3(std::sin(polar) * std::cos(azimuth),
                                            std::sin(polar) * std::sin(azimuth), std::cos(polar)));
    }
  }
  mesh.vertices.push_back({0, 0, -radius});
  const int south = int(mesh.vertices.size()) - 1;
  for (int j = 0; j < sectors; ++j) {
    const int next = (j + 1) % sectors;
    mesh.triangles.push_back({0, 1 + j, 1 + next});
    for (int i = 0; i + 2 < rings; ++i) {
      const int upper = 1 + i * sectors, lower = upper + sectors;
      mesh.triangles.push_back({upper + j, lower + j, lower + next});
      mesh.triangles.push_back({upper + j, lower + next, upper + next});
    }
    const int last = 1 + (rings - 2) * sectors;
    mesh.triangles.push_back({last + j, south, last + next});
  }
  return mesh;
}

bool isClosed(const TriangleMesh& mesh) {
  std::map<std::pair<int, int>, int> runs;
  for (const auto& t : mesh.triangles)
    for (int i = 0; i < 3; ++i) ++runs[{t[i], t[(i + 1) % 3]}];
  for (const auto& [edge, count] : runs)
    if (runs[{edge.second, edge.first}] != count) return false;
  return true;
}

TEST(MassProperties, BoxEqualsClosedForm) {
  const Vec3 edges(0.1, 0.2, 0.3), center(0.4, -0.5, 5);
  const MassProperties mass = massProperties(box(edges, center));
  const double volume = edges.prod();
  EXPECT_NEAR(mass.volume_m3, volume, 1e-15);
  EXPECT_LT((mass.centroid - center).norm(), 1e-13);
  const Vec3 squares = edges.cwiseProduct(edges);
  const Vec3 moments = volume / 12 * (Vec3::Constant(squares.sum()) - squares);
  EXPECT_LT((mass.inertia_m5 - Mat3(moments.asDiagonal())).norm(), 1e-16);
}

TEST(MassProperties, RightTetrahedronEqualsClosedForm) {
  // Corners at the origin and at 1 on each axis: volume 1/6; about the origin ∫x² = 1/60, ∫xy = 1/120.
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  const MassProperties mass = massProperties(mesh);
  EXPECT_NEAR(mass.volume_m3, 1. / 6, 1e-15);
  EXPECT_LT((mass.centroid - Vec3::Constant(0.25)).norm(), 1e-15);
  const double diagonal = 2 * (1. / 60 - 1. / 96);    // ∫y² + ∫z² about the centroid
  const double off_diagonal = -(1. / 120 - 1. / 96);  // -∫xy about the centroid
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) EXPECT_NEAR(mass.inertia_m5(i, j), i == j ? diagonal : off_diagonal, 1e-15);
}

TEST(MassProperties, FineSphereApproachesBall) {
  const double radius = 0.05;
  const MassProperties mass = massProperties(sphere(radius, 200));
  const double volume = 4. / 3 * std::numbers::pi * std::pow(radius, 3);
  EXPECT_NEAR(mass.volume_m3 / volume, 1, 2e-4);  // the inscribed polyhedron lacks O(1/rings²)
  EXPECT_LT(mass.centroid.norm(), 1e-12);
  const double moment = 0.4 * volume * radius * radius;
  EXPECT_LT((mass.inertia_m5 / moment - Mat3::Identity()).norm(), 1e-3);
}

TEST(MassProperties, RotateWithTheSolid) {
  TriangleMesh mesh = box({0.1, 0.2, 0.3}, {0, 0, 0});
  const Mat3 inertia = massProperties(mesh).inertia_m5;
  const Mat3 rotation = rotationFromVector({0.3, -1.2, 0.8});
  for (Vec3& vertex : mesh.vertices) vertex = rotation * vertex + Vec3(1, 2, 3);
  const MassProperties turned = massProperties(mesh);
  EXPECT_LT((turned.inertia_m5 - rotation * inertia * rotation.transpose()).norm(), 1e-15);
  EXPECT_LT((turned.centroid - Vec3(1, 2, 3)).norm(), 1e-14);
}

TEST(MassProperties, OpenBoxEqualsCappedBox) {
  TriangleMesh open = box({0.1, 0.2, 0.3}, {1, 1, 1});
  open.triangles.erase(open.triangles.begin() + 2, open.triangles.begin() + 4);  // the face at +z
  EXPECT_FALSE(isClosed(open));
  const MassProperties mass = massProperties(open);
  EXPECT_NEAR(mass.volume_m3, 0.006, 1e-15);
  EXPECT_LT((mass.centroid - Vec3(1, 1, 1)).norm(), 1e-13);
}

TEST(MassProperties, EmptyMeshIsZero) {
  EXPECT_EQ(massProperties({}).volume_m3, 0);
  EXPECT_EQ(massProperties({}).centroid, Vec3(0, 0, 0));
}

TEST(WithCaps, KeepsTheMeshAndClosesEveryLoop) {
  TriangleMesh tube = box({1, 1, 1}, {0, 0, 0});
  tube.triangles.erase(tube.triangles.begin(), tube.triangles.begin() + 4);  // both faces along z
  const TriangleMesh closed = withCaps(tube);
  ASSERT_EQ(closed.vertices.size(), 10u);
  ASSERT_EQ(closed.triangles.size(), 16u);
  EXPECT_TRUE(isClosed(closed));
  EXPECT_TRUE(std::equal(tube.triangles.begin(), tube.triangles.end(), closed.triangles.begin()));
  EXPECT_NEAR(std::abs(closed.vertices[8].z()), 0.5, 1e-15);
  EXPECT_NEAR(closed.vertices[8].z() + closed.vertices[9].z(), 0, 1e-15);
  EXPECT_NEAR(massProperties(tube).volume_m3, 1, 1e-14);
}

TEST(WithCaps, ClosesLoopsThatShareAPoint) {
  TriangleMesh mesh = sphere(1, 6);  // two triangles at the north pole taken out, not neighbours
  mesh.triangles.erase(mesh.triangles.begin() + 3 * 10);
  mesh.triangles.erase(mesh.triangles.begin());
  EXPECT_FALSE(isClosed(mesh));
  EXPECT_TRUE(isClosed(withCaps(mesh)));
  EXPECT_NEAR(massProperties(mesh).volume_m3, massProperties(sphere(1, 6)).volume_m3, 1e-12);
}

TEST(WithCaps, KeepsClosedMeshUnchanged) {
  const TriangleMesh closed = box({1, 1, 1}, {0, 0, 0});
  EXPECT_EQ(withCaps(closed).triangles, closed.triangles);
  EXPECT_EQ(withCaps(closed).vertices.size(), closed.vertices.size());
}

TEST(VertexNormals, SphereNormalsAreRadial) {
  const TriangleMesh mesh = sphere(0.05, 60);
  const std::vector<Vec3> normals = vertexNormals(mesh);
  ASSERT_EQ(normals.size(), mesh.vertices.size());
  for (size_t v = 0; v < normals.size(); ++v) {
    EXPECT_NEAR(normals[v].norm(), 1, 1e-12);
    EXPECT_GT(normals[v].dot(mesh.vertices[v].normalized()), 0.999);
  }
}

}  // namespace
}  // namespace airclay
