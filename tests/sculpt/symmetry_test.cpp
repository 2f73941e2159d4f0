// SPDX-License-Identifier: MIT
// Symmetry images, how their moves combine, and the orbits of control points.
#include "engine/sculpt/symmetry.h"

#include <algorithm>
#include <random>

#include "engine/clay/presets.h"
#include "tests/support/gpu_fixture.h"

namespace airclay {
namespace {

constexpr Symmetry kX{true, false, false}, kAllAxes{true, true, true};

TEST(Symmetry, ImagesCoverAllAxisCombinations) {
  EXPECT_EQ(imageCount(mirrorsOf({})), 1u);
  EXPECT_EQ(imageCount(mirrorsOf(kX)), 2u);
  EXPECT_EQ(imageCount(mirrorsOf({true, false, true})), 4u);
  EXPECT_EQ(imageCount(mirrorsOf(kAllAxes)), 8u);
  for (const Symmetry& symmetry : {Symmetry{}, kX, Symmetry{false, true, true}, kAllAxes}) {
    const std::uint32_t mirrors = mirrorsOf(symmetry);
    EXPECT_EQ(mirrorOf(mirrors, 0), Vec3(1, 1, 1));
    std::vector<Vec3> images;
    for (std::uint32_t image = 0; image < imageCount(mirrors); ++image) {
      const Vec3 signs = mirrorOf(mirrors, image);
      EXPECT_EQ(std::count(images.begin(), images.end(), signs), 0) << "each once";
      images.push_back(signs);
      EXPECT_TRUE(signs.x() == 1 || symmetry.x);
      EXPECT_TRUE(signs.y() == 1 || symmetry.y);
      EXPECT_TRUE(signs.z() == 1 || symmetry.z);
    }
  }
}

TEST(Symmetry, ImagesKeepTheLargerAndAddIndependentMoves) {
  EXPECT_EQ(combinedDisplacement({}), Vec3(0, 0, 0));
  EXPECT_EQ(combinedDisplacement({Vec3(1, -2, 3)}), Vec3(1, -2, 3));
  EXPECT_EQ(combinedDisplacement({Vec3(1, -2, 3), Vec3(2, -1, 3)}), Vec3(2, -2, 3));
  EXPECT_EQ(combinedDisplacement({Vec3(5, -2, 3), Vec3(-5, -2, 3)}), Vec3(0, -2, 3)) << "on the plane x = 0";
  EXPECT_EQ(combinedDisplacement({Vec3(5, 0, 0), Vec3(-3, 0, 0), Vec3(-4, 0, 0)}), Vec3(1, 0, 0));
}

TEST(Symmetry, OrbitsPartitionTheCage) {
  for (const std::string preset : {"ball", "cube", "slab"}) {
    const PolygonMesh cage = presetCage(preset);
    const SymmetryOrbits orbits = symmetryOrbits(cage, kAllAxes);
    ASSERT_EQ(orbits.mirrors, mirrorsOf(kAllAxes)) << preset;
    std::vector<int> seen(cage.points.size());
    for (std::size_t i = 0; i < orbits.points.size(); ++i) {
      const Vec3& first = cage.points[orbits.points[i - i % 8]];
      const Vec3 image = mirrorOf(orbits.mirrors, std::uint32_t(i % 8)).cwiseProduct(first);
      EXPECT_LT((cage.points[orbits.points[i]] - image).norm(), 1e-9);
      seen[orbits.points[i]] = 1;
    }
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), std::ptrdiff_t(seen.size()));
  }
  // seven columns have no image in one of the axes
  const SymmetryOrbits tube = symmetryOrbits(presetCage("tube"), kAllAxes);
  EXPECT_EQ(imageCount(tube.mirrors), 4u);
  PolygonMesh bent = presetCage("ball");
  bent.points[3] *= 1.001;
  EXPECT_TRUE(symmetryOrbits(bent, kAllAxes).points.empty() ||
              imageCount(symmetryOrbits(bent, kAllAxes).mirrors) < 8u);
  // the points are symmetric, the faces are not
  PolygonMesh cut = presetCage("ball");
  cut.faces.pop_back();
  EXPECT_LT(imageCount(symmetryOrbits(cut, kAllAxes).mirrors), 8u);
}

TEST(Symmetry, KernelEqualsTheReference) {
  Gpu& gpu = testGpu();
  const PolygonMesh cage = presetCage("ball");
  for (const Symmetry& symmetry : {kX, Symmetry{false, true, true}, kAllAxes}) {
    const SymmetryOrbits orbits = symmetryOrbits(cage, symmetry);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-1e-3, 1e-3);
    std::vector<Vec3> expected = cage.points;
    for (Vec3& point : expected) point += Vec3(uniform(random), uniform(random), uniform(random));
    std::vector<double> exact;
    for (const Vec3& point : expected) exact.insert(exact.end(), point.data(), point.data() + 3);
    const Buffer<double> exact_points(gpu, exact);
    const Buffer<vec3> control_points(gpu, expected.size());
    const Buffer<std::uint32_t> groups(gpu, std::vector<std::uint32_t>{2, 1, 1});
    SymmetryKeeper keeper(gpu);
    keeper.setOrbits(orbits);
    Recorder recorder(gpu);
    recorder.begin();
    keeper.recordIndirect(recorder, exact_points, control_points, groups.raw(), 0);
    recorder.submitAndWait();
    averageOrbits(orbits, expected);
    const std::vector<double> found = exact_points.download();
    const std::vector<vec3> rounded = control_points.download();
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_LT((Vec3(found[3 * i], found[3 * i + 1], found[3 * i + 2]) - expected[i]).norm(), 1e-15);
      EXPECT_EQ(rounded[i], vec3(expected[i].cast<float>()));
    }
    // the result is the expected average
    for (std::size_t i = 0; i < orbits.points.size(); ++i) {
      const std::uint32_t images = imageCount(orbits.mirrors), image = std::uint32_t(i) % images;
      EXPECT_EQ(expected[orbits.points[i]],
                mirrorOf(orbits.mirrors, image).cwiseProduct(expected[orbits.points[i - image]]));
    }
  }
}

}  // namespace
}  // namespace airclay
