// SPDX-License-Identifier: MIT
// The kernels of eq. (6)-(8) over all rows, compared with solveControlPoints and closed forms.
#include <cmath>

#include "engine/clay/presets.h"
#include "engine/clay/solve.h"
#include "tests/support/gpu_fixture.h"

namespace airclay {
namespace {

struct Solved {
  std::vector<Vec3> exact;
  std::vector<vec3> rounded;
};

/// p + A⁺ r on the GPU, `times` times.
Solved solveOnGpu(const StencilMatrix& matrix, const std::vector<Vec3>& control_points,
                  const std::vector<vec3>& displacements, int times = 1) {
  Gpu& gpu = testGpu();
  ControlPointSolver solver(gpu, matrix);
  std::vector<double> exact;
  for (const Vec3& point : control_points) exact.insert(exact.end(), point.data(), point.data() + 3);
  const Buffer<double> exact_points(gpu, exact);
  const Buffer<vec3> rounded_points(gpu, control_points.size());
  const Buffer<vec3> targets(gpu, displacements);
  Recorder recorder(gpu);
  recorder.begin();
  for (int i = 0; i < times; ++i) solver.record(recorder, targets, exact_points, rounded_points);
  recorder.submitAndWait();
  EXPECT_TRUE(hazards(recorder.commands()).empty());
  Solved solved{{}, rounded_points.download()};
  const std::vector<double> moved = exact_points.download();
  for (std::size_t i = 0; i < moved.size(); i += 3)
    solved.exact.emplace_back(moved[i], moved[i + 1], moved[i + 2]);
  return solved;
}

double difference(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum);
}

TEST(SolveGpu, EqualsThePseudoinverse) {
  for (const std::string& preset : presetNames())
    for (const SubdivisionRule rule : {SubdivisionRule::kCatmullClark, SubdivisionRule::kPrinted}) {
      SCOPED_TRACE(preset);
      const PolygonMesh cage = presetCage(preset);
      const StencilMatrix matrix = subdivide(cage, 2, rule).matrix;
      const std::vector<Vec3> points = dataPoints(matrix, cage.points);
      std::vector<vec3> displacements(points.size(), vec3(0, 0, 0));
      std::vector<Move> moves;
      for (std::size_t i = 0; i < points.size(); i += 7) {
        const double a = double(i);
        displacements[i] = 0.02f * vec3(float(std::sin(a)), float(std::cos(2 * a)), float(std::sin(3 * a)));
        moves.push_back({int(i), points[i] + displacements[i].cast<double>()});
      }
      const std::vector<Vec3> expected = solveControlPoints(matrix, cage.points, moves, &kSolveAll);
      const Solved solved = solveOnGpu(matrix, cage.points, displacements);
      EXPECT_LE(difference(solved.exact, expected), 1e-5 * difference(expected, cage.points));
      for (std::size_t i = 0; i < expected.size(); ++i)
        EXPECT_EQ(solved.rounded[i], vec3(solved.exact[i].cast<float>()));
    }
}

TEST(SolveGpu, RigidTranslationIsExact) {
  const PolygonMesh cage = presetCage("tube");
  const StencilMatrix matrix = subdivide(cage, 2, SubdivisionRule::kCatmullClark).matrix;
  const vec3 shift(0.01f, -0.02f, 0.005f);
  const Solved solved = solveOnGpu(matrix, cage.points, std::vector<vec3>(std::size_t(matrix.rows()), shift));
  for (std::size_t i = 0; i < cage.points.size(); ++i)
    EXPECT_LT((solved.exact[i] - cage.points[i] - shift.cast<double>()).norm(), 1e-6 * shift.norm());
}

TEST(SolveGpu, ThousandsOfFramesDoNotDrift) {
  // back and forth, 1,000 times 1 mm: a float position of 0.1 m would drift by up to 1e-5 m
  const PolygonMesh cage = presetCage("tube");
  const StencilMatrix matrix = subdivide(cage, 2, SubdivisionRule::kCatmullClark).matrix;
  std::vector<vec3> displacements(std::size_t(matrix.rows()), vec3(0, 0, 0));
  displacements[100] = vec3(0.001f, 0.0007f, -0.0003f);
  const Solved there = solveOnGpu(matrix, cage.points, displacements, 1000);
  displacements[100] = -displacements[100];
  const Solved back = solveOnGpu(matrix, there.exact, displacements, 1000);
  EXPECT_GT(difference(there.exact, cage.points), 0.1);
  EXPECT_LT(difference(back.exact, cage.points), 1e-12);
}

TEST(SolveGpu, CachedTouchedRowsFactorEqualsThePseudoinverse) {
  const PolygonMesh cage = presetCage("vase");
  const StencilMatrix matrix = subdivide(cage, 2, SubdivisionRule::kCatmullClark).matrix;
  for (const int count : {5, 300}) {  // fewer rows than control points, and more
    std::vector<int> rows;
    for (int i = 0; i < count; ++i) rows.push_back(100 + 4 * i);
    const double damping = 0.1;
    const TouchedRowsSolver solver(matrix, rows, damping);
    for (int shape = 0; shape < 2; ++shape) {
      Eigen::MatrixXd touched(count, matrix.cols()), targets(count, 3);
      std::vector<Vec3> displacements;
      for (int i = 0; i < count; ++i) {
        displacements.emplace_back(0.01 * std::sin(i + shape), 0.01 * std::cos(2 * i), 0.003);
        targets.row(i) = displacements.back().transpose();
        touched.row(i) = Eigen::MatrixXd(matrix.middleRows(rows[std::size_t(i)], 1));
      }
      const Eigen::MatrixXd gram =
          touched * touched.transpose() + damping * damping * Eigen::MatrixXd::Identity(count, count);
      const Eigen::MatrixXd expected = touched.transpose() * gram.ldlt().solve(targets);
      const std::vector<Vec3> moved = solver.controlDisplacements(displacements);
      for (std::size_t i = 0; i < moved.size(); ++i)
        EXPECT_LT((moved[i] - expected.row(Eigen::Index(i)).transpose()).norm(), 1e-9 * expected.norm());
    }
  }
}

}  // namespace
}  // namespace airclay
