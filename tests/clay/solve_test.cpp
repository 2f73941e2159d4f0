// SPDX-License-Identifier: MIT
// Eq. (6)-(8) compared with the pseudoinverse from singular values of the dense matrix, and closed forms.
#include "engine/clay/solve.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <fstream>
#include <numeric>
#include <random>

#include "engine/clay/presets.h"
#include "engine/core/error.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

using Eigen::MatrixXd;

/// Moore-Penrose by one-sided Jacobi rotations of the full matrix: slow, and independent of the solver.
MatrixXd pseudoinverse(const MatrixXd& matrix) {
  const Eigen::JacobiSVD<MatrixXd> svd(matrix, Eigen::ComputeThinU | Eigen::ComputeThinV);
  Eigen::VectorXd inverse = svd.singularValues();
  for (double& value : inverse) value = value > kSingularCutoff * svd.singularValues()[0] ? 1 / value : 0;
  return svd.matrixV() * inverse.asDiagonal() * svd.matrixU().transpose();
}

struct Clay {
  PolygonMesh cage;
  StencilMatrix matrix;
  std::vector<Vec3> data_points;
};

Clay prepareClay(const std::string& preset, int levels = 2,
                 SubdivisionRule rule = SubdivisionRule::kCatmullClark) {
  Clay clay;
  clay.cage = presetCage(preset);
  clay.matrix = subdivide(clay.cage, levels, rule).matrix;
  clay.data_points = dataPoints(clay.matrix, clay.cage.points);
  return clay;
}

/// The given data points, each moved by up to a centimetre along each axis.
std::vector<Move> randomMoves(const Clay& clay, const std::vector<int>& indices) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> offset_m(-0.01, 0.01);
  std::vector<Move> moves;
  for (const int index : indices)
    moves.push_back({index, clay.data_points[size_t(index)] +
                                Vec3(offset_m(random), offset_m(random), offset_m(random))});
  return moves;
}

std::vector<int> range(int first, int count, int step = 1) {
  std::vector<int> indices;
  for (int i = 0; i < count; ++i) indices.push_back(first + i * step);
  return indices;
}

/// Control points by definition: p + A⁺ (d_new - d), A the chosen rows.
std::vector<Vec3> expected(const Clay& clay, const std::vector<Move>& moves, const SolveMethod* rows) {
  const MatrixXd dense = clay.matrix;
  const bool all = rows == &kSolveAll;
  MatrixXd chosen = all ? dense : MatrixXd(Eigen::Index(moves.size()), dense.cols());
  MatrixXd targets = MatrixXd::Zero(chosen.rows(), 3);
  for (size_t i = 0; i < moves.size(); ++i) {
    const Eigen::Index row = all ? moves[i].index : Eigen::Index(i);
    chosen.row(row) = dense.row(moves[i].index);
    targets.row(row) = (moves[i].target - clay.data_points[size_t(moves[i].index)]).transpose();
  }
  const MatrixXd moved = pseudoinverse(chosen) * targets;
  std::vector<Vec3> points = clay.cage.points;
  for (size_t i = 0; i < points.size(); ++i) points[i] += moved.row(Eigen::Index(i)).transpose();
  return points;
}

double largestDifference(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  EXPECT_EQ(a.size(), b.size());
  double largest = 0;
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

void expectMoorePenrose(const Clay& clay, const std::vector<Move>& moves, const SolveMethod* rows) {
  const std::vector<Vec3> solved = solveControlPoints(clay.matrix, clay.cage.points, moves, rows);
  const std::vector<Vec3> truth = expected(clay, moves, rows);
  const double moved_m = largestDifference(truth, clay.cage.points);
  ASSERT_GT(moved_m, 1e-4);
  EXPECT_LT(largestDifference(solved, truth), 1e-10 * moved_m);
}

TEST(Solve, AllRowsEqualsThePseudoinverse) {
  for (const char* preset : {"tube", "cube", "ball", "slab"})
    for (const SubdivisionRule rule : {SubdivisionRule::kCatmullClark, SubdivisionRule::kPrinted}) {
      SCOPED_TRACE(preset);
      const Clay clay = prepareClay(preset, 2, rule);
      expectMoorePenrose(clay, randomMoves(clay, range(3, 20, 4)), &kSolveAll);
    }
}

TEST(Solve, AllRowsDropsSingularDirectionAcrossBlocks) {
  // Catmull-Clark's A of a cube has a rank deficiency of one: moving every other corner inwards moves no data
  // point.
  const Clay clay = prepareClay("cube", 5);
  ASSERT_EQ(clay.matrix.rows(), 6146);
  Eigen::VectorXd every_other(8);
  for (int i = 0; i < 8; ++i) {
    const Vec3& point = clay.cage.points[size_t(i)];
    every_other[i] = point.x() * point.y() * point.z() > 0 ? 1 : -1;
  }
  ASSERT_LT((clay.matrix * every_other).norm(), 1e-12);
  expectMoorePenrose(clay, randomMoves(clay, range(0, 200, 30)), &kSolveAll);
}

TEST(Solve, TouchedRowsEqualsThePseudoinverse) {
  const Clay tube = prepareClay("tube");
  expectMoorePenrose(tube, randomMoves(tube, {100}), &kSolveTouched);
  expectMoorePenrose(tube, randomMoves(tube, range(0, 5, 60)), &kSolveTouched);
  expectMoorePenrose(tube, randomMoves(tube, range(0, 364)), &kSolveTouched);
  const Clay cube = prepareClay("cube");
  expectMoorePenrose(cube, randomMoves(cube, range(0, 98)), &kSolveTouched);
  const Clay ball = prepareClay("ball");
  expectMoorePenrose(ball, randomMoves(ball, range(5, 40, 3)), &kSolveTouched);
}

TEST(Solve, TouchedRowsSolvesRankDeficientRows) {
  // The face, edge and vertex points around one quad, four levels deep: bicubic, so at most 16 of these
  // rows of a regular grid are independent.
  const Clay slab = prepareClay("slab", 4);
  std::vector<int> near;
  const Vec3 top(0, 0, slab.data_points[0].z());
  for (int i = 0; i < int(slab.data_points.size()); ++i) {
    const Vec3& point = slab.data_points[size_t(i)];
    if (point.z() > 0 && std::abs(point.x()) < 0.0199 && std::abs(point.y()) < 0.0199) near.push_back(i);
  }
  ASSERT_GT(near.size(), 30u);
  MatrixXd rows(Eigen::Index(near.size()), slab.matrix.cols());
  for (size_t i = 0; i < near.size(); ++i) rows.row(Eigen::Index(i)) = MatrixXd(slab.matrix.row(near[i]));
  const Eigen::VectorXd values = Eigen::JacobiSVD<MatrixXd>(rows).singularValues();
  ASSERT_GT(values[15], 1e-6 * values[0]);
  ASSERT_LT(values[16], 1e-12 * values[0]);
  const std::vector<Move> moves = randomMoves(slab, near);
  const std::vector<Vec3> solved = solveControlPoints(slab.matrix, slab.cage.points, moves, &kSolveTouched);
  const std::vector<Vec3> truth = expected(slab, moves, &kSolveTouched);
  const double moved_m = largestDifference(truth, slab.cage.points);
  // The precision of the result: the rounding of the data, 1e-16, times the rows' condition number.
  EXPECT_LT(largestDifference(solved, truth), 1e-14 * values[0] / values[15] * moved_m);
}

TEST(Solve, OneMovedPointReachesItsTargetWithMinimumNorm) {
  const Clay clay = prepareClay("tube");
  const Move move{200, clay.data_points[200] + Vec3(0.01, -0.02, 0.005)};
  const std::vector<Vec3> solved = solveControlPoints(clay.matrix, clay.cage.points, {move}, &kSolveTouched);
  EXPECT_LT((dataPoints(clay.matrix, solved)[200] - move.target).norm(), 1e-15);
  // (7) for one row: aᵀ / (a aᵀ).
  const Eigen::VectorXd row = MatrixXd(clay.matrix.row(200)).transpose();
  for (size_t i = 0; i < solved.size(); ++i)
    EXPECT_LT((solved[i] - clay.cage.points[i] -
               row[Eigen::Index(i)] / row.squaredNorm() * (move.target - clay.data_points[200]))
                  .norm(),
              1e-15);
}

TEST(Solve, TranslatingAllPointsTranslatesTheCage) {
  const Vec3 step(0.03, -0.02, 0.05);
  for (const std::string& preset : presetNames()) {
    const Clay clay = prepareClay(preset);
    std::vector<Move> moves;
    for (size_t i = 0; i < clay.data_points.size(); ++i)
      moves.push_back({int(i), clay.data_points[i] + step});
    for (const SolveMethod* rows : {&kSolveAll, &kSolveTouched}) {
      const std::vector<Vec3> solved = solveControlPoints(clay.matrix, clay.cage.points, moves, rows);
      for (size_t i = 0; i < solved.size(); ++i)
        EXPECT_LT((solved[i] - clay.cage.points[i] - step).norm(), 1e-13) << preset;
    }
  }
}

TEST(Solve, NoMovesGiveNoDisplacement) {
  const Clay clay = prepareClay("vase");
  std::vector<Move> stay;
  for (int i = 0; i < 30; ++i) stay.push_back({i, clay.data_points[size_t(i)]});
  for (const SolveMethod* rows : {&kSolveAll, &kSolveTouched}) {
    EXPECT_EQ(solveControlPoints(clay.matrix, clay.cage.points, {}, rows), clay.cage.points);
    EXPECT_EQ(solveControlPoints(clay.matrix, clay.cage.points, stay, rows), clay.cage.points);
  }
  EXPECT_EQ(solveControlPoints(clay.matrix, clay.cage.points, stay, &kSolveTouched, kTouchedDamping),
            clay.cage.points);
}

TEST(Solve, DampedSolveEqualsClosedForm) {
  const Clay clay = prepareClay("tube");
  for (const int count : {1, 10, 28, 100, 364}) {  // fewer rows than control points, and more
    const std::vector<Move> moves = randomMoves(clay, range(0, count));
    MatrixXd rows(count, clay.matrix.cols()), targets(count, 3);
    for (int i = 0; i < count; ++i) {
      rows.row(i) = MatrixXd(clay.matrix.row(moves[size_t(i)].index));
      targets.row(i) =
          (moves[size_t(i)].target - clay.data_points[size_t(moves[size_t(i)].index)]).transpose();
    }
    const double lambda = 0.1;
    const MatrixXd damped = rows * rows.transpose() + lambda * lambda * MatrixXd::Identity(count, count);
    const MatrixXd moved = rows.transpose() * damped.fullPivLu().solve(targets);
    const std::vector<Vec3> solved =
        solveControlPoints(clay.matrix, clay.cage.points, moves, &kSolveTouched, lambda);
    for (size_t i = 0; i < solved.size(); ++i)
      EXPECT_LT((solved[i] - clay.cage.points[i] - moved.row(Eigen::Index(i)).transpose()).norm(), 1e-13);
  }
}

TEST(Solve, DampingBoundsNoiseAmplification) {
  const Clay clay = prepareClay("tube", 4);
  std::vector<int> nearest = range(0, int(clay.data_points.size()));
  const auto distance = [&](int i) { return (clay.data_points[size_t(i)] - clay.data_points[500]).norm(); };
  std::sort(nearest.begin(), nearest.end(), [&](int a, int b) { return distance(a) < distance(b); });
  nearest.resize(10);
  std::mt19937 random(11);
  std::normal_distribution<double> noise_m(0, 0.001);
  std::vector<Move> moves;
  double noise_norm = 0;
  for (const int i : nearest) {
    const Vec3 noise(noise_m(random), noise_m(random), noise_m(random));
    noise_norm = std::hypot(noise_norm, noise.norm());
    moves.push_back({i, clay.data_points[size_t(i)] + noise});
  }
  const auto thrown = [&](double damping) {
    const std::vector<Vec3> solved =
        solveControlPoints(clay.matrix, clay.cage.points, moves, &kSolveTouched, damping);
    double sum = 0;
    for (size_t i = 0; i < solved.size(); ++i) sum += (solved[i] - clay.cage.points[i]).squaredNorm();
    return std::sqrt(sum);
  };
  EXPECT_GT(thrown(0), 1.0);                                               // one metre from one millimetre
  EXPECT_LE(thrown(kTouchedDamping), noise_norm / (2 * kTouchedDamping));  // σ / (σ² + λ²) <= 1 / 2λ
}

TEST(Solve, AllRowsSolverEqualsTheGramPseudoinverse) {
  for (const char* preset : {"tube", "cube", "ball", "vase"}) {
    SCOPED_TRACE(preset);
    const Clay clay = prepareClay(preset);
    const AllRowsSolver solver(clay.matrix);
    const MatrixXd inverse = pseudoinverse(clay.matrix);
    const MatrixXd truth = inverse * inverse.transpose();  // (AᵀA)⁺ = A⁺ A⁺ᵀ
    EXPECT_LT((solver.gramInverse() - truth).norm(), 1e-11 * truth.norm());
    EXPECT_EQ(solver.gramInverse(), solver.gramInverse().transpose());

    const std::vector<Move> moves = randomMoves(clay, range(0, 30, 2));
    std::vector<Vec3> data_displacements(clay.data_points.size(), Vec3::Zero());
    for (const Move& move : moves)
      data_displacements[size_t(move.index)] = move.target - clay.data_points[size_t(move.index)];
    std::vector<Vec3> solved = solver.controlDisplacements(clay.matrix, data_displacements);
    for (size_t i = 0; i < solved.size(); ++i) solved[i] += clay.cage.points[i];
    EXPECT_LT(largestDifference(solved, expected(clay, moves, &kSolveAll)), 1e-12);
  }
}

TEST(Solve, RejectsInvalidInput) {
  const Clay clay = prepareClay("tube");
  const auto solve = [&](const std::vector<Move>& moves, const SolveMethod* rows, double damping) {
    return solveControlPoints(clay.matrix, clay.cage.points, moves, rows, damping);
  };
  EXPECT_THROW(solve({{364, Vec3::Zero()}}, &kSolveTouched, 0), Error);
  EXPECT_THROW(solve({{-1, Vec3::Zero()}}, &kSolveAll, 0), Error);
  EXPECT_THROW(solve({{5, Vec3::Zero()}, {5, Vec3::Ones()}}, &kSolveTouched, 0), Error);
  EXPECT_THROW(solve({{5, Vec3::Zero()}}, &kSolveAll, 0.1), Error);
  EXPECT_THROW(AllRowsSolver(StencilMatrix(5000, 4097)), Error);
}

class MovesFile : public ::testing::Test {
 protected:
  std::vector<Move> read(const std::string& content) const {
    std::ofstream(file_, std::ios::binary) << content;
    return readMoves(file_, 364);
  }
  TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_ / "moves.csv";
};

TEST_F(MovesFile, ReadsMoves) {
  const std::vector<Move> moves = read("index,x,y,z\r\n\r\n3,0.1,-2e-3,+5\r\n 0 , 1 ,2,3.123456789012\n\n");
  ASSERT_EQ(moves.size(), 2u);
  EXPECT_EQ(moves[0].index, 3);
  EXPECT_EQ(moves[0].target, Vec3(0.1, -2e-3, 5));
  EXPECT_EQ(moves[1].index, 0);
  EXPECT_EQ(moves[1].target, Vec3(1, 2, 3.123456789012));
  EXPECT_TRUE(read("index,x,y,z\n").empty());
}

TEST_F(MovesFile, ErrorsNameFileAndLine) {
  struct Case {
    std::string content, line, what;
  };
  const Case cases[] = {{"", "", "header"},
                        {"3,0,0,0\n", ":1:", "header"},
                        {"index,x,y\n", ":1:", "header"},
                        {"index,x,y,z\n364,0,0,0\n", ":2:", "0 to 363"},
                        {"index,x,y,z\n-1,0,0,0\n", ":2:", "0 to 363"},
                        {"index,x,y,z\n99999999999999,0,0,0\n", ":2:", "0 to 363"},
                        {"index,x,y,z\n1.5,0,0,0\n", ":2:", "whole number"},
                        {"index,x,y,z\n,0,0,0\n", ":2:", "whole number"},
                        {"index,x,y,z\n\n1,0,0\n", ":3:", "four values"},
                        {"index,x,y,z\n1,0,0,0,0\n", ":2:", "four values"},
                        {"index,x,y,z\n1,0,nan,0\n", ":2:", "'nan'"},
                        {"index,x,y,z\n1,0,,0\n", ":2:", "''"},
                        {"index,x,y,z\n7,0,0,0\n8,0,0,0\n7,1,1,1\n", ":4:", "line 2"}};
  for (const Case& bad : cases) {
    try {
      read(bad.content);
      ADD_FAILURE() << "no error for " << bad.content;
    } catch (const Error& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find(file_.string() + bad.line), std::string::npos) << message;
      EXPECT_NE(message.find(bad.what), std::string::npos) << message;
    }
  }
  EXPECT_THROW(readMoves(file_.string() + ".none", 364), Error);
}

}  // namespace
}  // namespace airclay
