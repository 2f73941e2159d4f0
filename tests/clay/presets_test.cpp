// SPDX-License-Identifier: MIT
// The presets: manifold quads of the documented size, and the paper's counts.
#include "engine/clay/presets.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "engine/clay/subdivide.h"
#include "engine/core/error.h"
#include "engine/mesh/manifold.h"
#include "engine/mesh/mesh_file.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

/// Sum of signed tetrahedra; positive if a closed mesh's faces are counterclockwise from outside.
double signedVolume(const PolygonMesh& mesh) {
  double six_times = 0;
  for (const std::vector<int>& face : mesh.faces)
    for (size_t k = 2; k < face.size(); ++k)
      six_times += mesh.points[size_t(face[0])].dot(
          mesh.points[size_t(face[k - 1])].cross(mesh.points[size_t(face[k])]));
  return six_times / 6;
}

int borderEdges(const PolygonMesh& mesh) {
  std::vector<std::pair<int, int>> sides;
  for (const std::vector<int>& face : mesh.faces)
    for (size_t k = 0; k < face.size(); ++k) sides.emplace_back(face[k], face[(k + 1) % face.size()]);
  int count = 0;
  for (const auto& [from, to] : sides)
    count += std::count(sides.begin(), sides.end(), std::pair(to, from)) == 0;
  return count;
}

TEST(Presets, AreCentredManifoldQuadsOfAboutTwentyCentimetres) {
  ASSERT_EQ(presetNames().front(), "tube");
  for (const std::string& name : presetNames()) {
    SCOPED_TRACE(name);
    const PolygonMesh cage = presetCage(name);
    EXPECT_NO_THROW(checkCage(cage, name));
    for (const std::vector<int>& face : cage.faces) EXPECT_EQ(face.size(), 4u);
    Vec3 low = cage.points[0], high = cage.points[0];
    for (const Vec3& point : cage.points) {
      low = low.cwiseMin(point);
      high = high.cwiseMax(point);
    }
    EXPECT_LT((low + high).norm() / 2, 0.005);  // seven points around the axis are not exactly symmetric
    EXPECT_GE((high - low).maxCoeff(), 0.15);
    EXPECT_LE((high - low).maxCoeff(), 0.25);
    EXPECT_EQ(borderEdges(cage), name == "tube" ? 14 : 0);
  }
}

TEST(Presets, FacesPointOutwards) {
  for (const char* name : {"cube", "ball", "slab", "vase"})
    EXPECT_GT(signedVolume(presetCage(name)), 0) << name;
  EXPECT_NEAR(signedVolume(presetCage("cube")), 0.008, 1e-12);
  EXPECT_NEAR(signedVolume(presetCage("slab")), 0.2 * 0.2 * 0.04, 1e-12);
  const PolygonMesh tube = presetCage("tube");
  for (const std::vector<int>& face : tube.faces) {
    const Vec3& a = tube.points[size_t(face[0])];
    const Vec3 normal = (tube.points[size_t(face[1])] - a).cross(tube.points[size_t(face[3])] - a);
    EXPECT_GT(normal.dot(Vec3(a.x(), a.y(), 0)), 0);
  }
}

TEST(Presets, TubeHasThePapersCounts) {
  const PolygonMesh tube = presetCage("tube");
  EXPECT_EQ(tube.points.size(), 28u);
  EXPECT_EQ(subdivide(tube, 1, SubdivisionRule::kCatmullClark).matrix.rows(), 98);
  EXPECT_EQ(subdivide(tube, 2, SubdivisionRule::kCatmullClark).matrix.rows(), 364);
  EXPECT_EQ(subdivide(tube, 2, SubdivisionRule::kPrinted).matrix.rows(), 364);
}

TEST(Presets, BallIsRound) {
  const PolygonMesh cage = presetCage("ball");
  const Subdivision subdivision = subdivide(cage, 3, SubdivisionRule::kCatmullClark);
  for (const Vec3& point : dataPoints(subdivision.matrix, cage.points))
    EXPECT_NEAR(point.norm(), 0.1, 0.0015);
}

TEST(Presets, CubeHasEightPoints) {
  EXPECT_EQ(presetCage("cube").points.size(), 8u);
}

TEST(Presets, UnknownPresetErrorListsAllPresets) {
  for (const bool as_file : {false, true}) {
    try {
      as_file ? loadCage("teapot").cage : presetCage("teapot");
      FAIL() << "no error";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("teapot"), std::string::npos);
      EXPECT_NE(std::string(error.what()).find("tube, cube, ball, slab, vase"), std::string::npos);
    }
  }
}

TEST(Presets, LoadCageReadsPresetsAndFiles) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "vase.obj";
  writeObj(file, presetCage("vase"));
  EXPECT_EQ(loadCage(file.string()).cage.faces, presetCage("vase").faces);
  std::filesystem::remove(file);
  EXPECT_EQ(loadCage("slab").cage.faces, presetCage("slab").faces);
  EXPECT_THROW(loadCage(file.string()), Error);
}

}  // namespace
}  // namespace airclay
