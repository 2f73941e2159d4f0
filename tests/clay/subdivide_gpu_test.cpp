// SPDX-License-Identifier: MIT
// The kernels `subdivide` and `normals` compared with their double-precision references.
#include "engine/clay/presets.h"
#include "engine/clay/subdivide.h"
#include "tests/support/gpu_fixture.h"

namespace airclay {
namespace {

double largestNorm(const std::vector<Vec3>& vectors) {
  double largest = 0;
  for (const Vec3& vector : vectors) largest = std::max(largest, vector.norm());
  return largest;
}

/// Evaluates two shapes of the cage in turn: the first must not affect the second.
void expectEqualsReference(PolygonMesh cage, int levels, SubdivisionRule rule) {
  Gpu& gpu = testGpu();
  const Subdivision subdivision = subdivide(cage, levels, rule);
  SurfaceEvaluator evaluator(gpu, subdivision);
  ASSERT_EQ(evaluator.dataPointCount(), std::size_t(subdivision.matrix.rows()));
  Recorder recorder(gpu);
  for (int shape = 0; shape < 2; ++shape) {
    for (std::size_t i = 0; i < cage.points.size(); ++i)
      cage.points[i] +=
          0.01 * Vec3(std::sin(1.0 * double(i)), std::sin(2.3 * double(i)), std::sin(3.1 * double(i)));
    std::vector<vec3> control_points;
    for (const Vec3& point : cage.points) control_points.push_back(point.cast<float>());
    const Buffer<vec3> control(gpu, control_points);
    recorder.begin();
    evaluator.record(recorder, control);
    recorder.submitAndWait();
    EXPECT_TRUE(hazards(recorder.commands()).empty());

    const std::vector<Vec3> points = dataPoints(subdivision.matrix, cage.points);
    const std::vector<vec3> gpu_points = evaluator.dataPoints().download();
    // from the kernel's own points: a float's rounding of a position is large compared to a small quad
    std::vector<Vec3> rounded;
    for (const vec3& point : gpu_points) rounded.push_back(point.cast<double>());
    const std::vector<Vec3> normals = dataNormals(subdivision.quads, rounded);
    const std::vector<vec3> gpu_normals = evaluator.normals().download();
    const double scale = largestNorm(points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      ASSERT_LE((gpu_points[i].cast<double>() - points[i]).norm(), 1e-6 * scale) << i;
      ASSERT_LE((gpu_normals[i].cast<double>() - normals[i]).norm(), 1e-5) << i;
    }
  }
}

TEST(SubdivideGpu, EqualsTheReference) {
  for (const SubdivisionRule rule : {SubdivisionRule::kCatmullClark, SubdivisionRule::kPrinted})
    for (const std::string& name : presetNames())
      for (const int levels : {1, 2, 4}) {
        SCOPED_TRACE(name + " " + std::to_string(levels));
        expectEqualsReference(presetCage(name), levels, rule);
      }
}

TEST(SubdivideGpu, AcceptsFacesWithAnyNumberOfSides) {
  PolygonMesh cage;  // a pyramid over a pentagon: triangles, a pentagon, points of valence 3 and 5
  cage.points = {{0, 0, 0.2}};
  std::vector<int> base;
  for (int i = 0; i < 5; ++i) {
    cage.points.emplace_back(0.1 * std::cos(2 * M_PI * i / 5), 0.1 * std::sin(2 * M_PI * i / 5), 0);
    cage.faces.push_back({0, 1 + i, 1 + (i + 1) % 5});
    base.insert(base.begin(), 1 + i);
  }
  cage.faces.push_back(base);
  for (const SubdivisionRule rule : {SubdivisionRule::kCatmullClark, SubdivisionRule::kPrinted})
    expectEqualsReference(cage, 3, rule);
}

TEST(SubdivideGpu, NormalsAreUnitOrZeroOnDegenerateSurfaces) {
  Gpu& gpu = testGpu();
  const PolygonMesh cage = presetCage("cube");
  const Subdivision subdivision = subdivide(cage, 2, SubdivisionRule::kCatmullClark);
  SurfaceEvaluator evaluator(gpu, subdivision);
  Recorder recorder(gpu);
  for (const float scale : {1e-12f, 0.0f}) {
    std::vector<vec3> points;
    for (const Vec3& point : cage.points) points.push_back(scale * point.cast<float>());
    const Buffer<vec3> control(gpu, points);
    recorder.begin();
    evaluator.record(recorder, control);
    recorder.submitAndWait();
    for (const vec3& normal : evaluator.normals().download())
      ASSERT_NEAR(normal.norm(), scale > 0 ? 1 : 0, 1e-5);
  }
}

TEST(SubdivideGpu, SupportsMoreWorkgroupsThanTheXLimit) {
  Gpu& gpu = testGpu();
  const int rows = 65'535 * int(kSubdivideWorkgroup) + 1000;
  const auto weight = [](int row) { return double(row % 997); };
  Subdivision subdivision;
  subdivision.matrix.resize(rows, 1);
  subdivision.matrix.reserve(Eigen::VectorXi::Ones(rows));
  for (int row = 0; row < rows; ++row) subdivision.matrix.insert(row, 0) = weight(row);
  subdivision.matrix.makeCompressed();
  SurfaceEvaluator evaluator(gpu, subdivision);
  const Buffer<vec3> control(gpu, std::vector<vec3>{vec3(1, 2, -3)});
  Recorder recorder(gpu);
  recorder.begin();
  evaluator.record(recorder, control);
  recorder.submitAndWait();
  const std::vector<vec3> points = evaluator.dataPoints().download();
  for (int row = 0; row < rows; ++row)
    ASSERT_EQ(points[std::size_t(row)], vec3(float(weight(row)) * vec3(1, 2, -3))) << row;
}

}  // namespace
}  // namespace airclay
