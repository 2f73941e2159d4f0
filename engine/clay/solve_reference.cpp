// SPDX-License-Identifier: MIT
// Eq. (6)-(8) on the CPU in double precision: the reference of the kernel `solve`, and the solver of
// `deform`.
//
// If A is well conditioned, its pseudoinverse is (AᵀA)⁻¹Aᵀ, by Cholesky. Squaring A halves the accurate
// digits, so an ill-conditioned A is solved by its singular values instead (dense_pseudoinverse.h).
#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <optional>

#include "engine/clay/dense_pseudoinverse.h"
#include "engine/clay/solve.h"
#include "engine/clay/touched_rows.h"
#include "engine/core/error.h"
#include "engine/core/task.h"

namespace airclay {
namespace {

using Eigen::MatrixXd;
using Displacements = Eigen::Matrix<double, Eigen::Dynamic, 3>;  ///< one per row, metres

// The smallest pivot ratio of AᵀA. Its singular values are the squares of A's, so those of A are all above
// 1e-4 of the largest, far from kSingularCutoff: none is truncated, and Cholesky is accurate to 1e-8 before
// and 1e-12 after one refinement step.
constexpr double kWellConditioned = 1e-8;

// A larger refinement step means that the pivots underestimate the condition number.
constexpr double kSmallCorrection = 1e-6;

/// Eq. (6) in displacements: d_new - d of the moved rows.
Displacements moveDisplacements(const StencilMatrix& matrix, const std::vector<Vec3>& control_points,
                                const std::vector<Move>& moves) {
  Displacements displacements(Eigen::Index(moves.size()), 3);
  for (size_t i = 0; i < moves.size(); ++i) {
    Vec3 data_point = Vec3::Zero();
    for (StencilMatrix::InnerIterator entry(matrix, moves[i].index); entry; ++entry)
      data_point += entry.value() * control_points[size_t(entry.col())];  // (5)
    displacements.row(Eigen::Index(i)) = (moves[i].target - data_point).transpose();
  }
  return displacements;
}

/// A⁺ b as (AᵀA)⁻¹Aᵀ b, or with fewer rows than columns as eq. (7), Aᵀ(AAᵀ)⁻¹ b; empty if A is too
/// ill-conditioned for either.
std::optional<Displacements> solveNormalEquations(const StencilMatrix& matrix,
                                                  const Displacements& right_side) {
  const StencilMatrix transposed = matrix.transpose();
  const bool wide = matrix.rows() < matrix.cols();
  const Eigen::SparseMatrix<double> gram = wide ? matrix * transposed : transposed * matrix;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(gram);
  if (factor.info() != Eigen::Success) return std::nullopt;
  const Eigen::VectorXd pivots = factor.vectorD();
  if (!(pivots.minCoeff() > kWellConditioned * pivots.maxCoeff())) return std::nullopt;
  const auto solve = [&](const Displacements& b) -> Displacements {
    if (wide) return transposed * Displacements(factor.solve(b));
    return factor.solve(Displacements(transposed * b));
  };
  const Displacements solution = solve(right_side);
  const Displacements correction =
      solve(right_side - matrix * solution);  // residual with A itself, not its square
  if (!(correction.norm() <= kSmallCorrection * solution.norm())) return std::nullopt;
  return Displacements(solution + correction);
}

/// A⁺ b, exact Moore-Penrose: the smallest of all best-fitting x, singular values truncated at
/// kSingularCutoff.
Displacements pseudoinverseTimes(const StencilMatrix& matrix, const Displacements& right_side) {
  if (const auto solution = solveNormalEquations(matrix, right_side)) return *solution;
  if (matrix.cols() > AllRowsSolver::kMaxControlPoints)
    throw Error("the solve for these moves is ill-conditioned over " + std::to_string(matrix.cols()) +
                " control points; expected at most " + std::to_string(AllRowsSolver::kMaxControlPoints));
  return densePseudoinverseTimes(matrix, right_side);
}

void checkMoves(const StencilMatrix& matrix, const std::vector<Move>& moves) {
  std::vector<int> indices;
  for (const Move& move : moves) indices.push_back(move.index);
  std::sort(indices.begin(), indices.end());
  if (!indices.empty() && (indices.front() < 0 || indices.back() >= matrix.rows()))
    throw Error("a move's data point is out of range; expected 0 to " + std::to_string(matrix.rows() - 1));
  if (const auto twice = std::adjacent_find(indices.begin(), indices.end()); twice != indices.end())
    throw Error("data point " + std::to_string(*twice) + " is moved twice; expected each point once");
}

}  // namespace

std::vector<Vec3> solveControlPoints(const StencilMatrix& matrix, const std::vector<Vec3>& control_points,
                                     const std::vector<Move>& moves, const SolveMethod* method,
                                     double damping) {
  checkMoves(matrix, moves);
  std::vector<Vec3> solved = control_points;
  if (moves.empty()) return solved;
  const Displacements targets = moveDisplacements(matrix, control_points, moves);
  if (method->fits_unmoved) {
    if (damping > 0) throw Error("the solve over all rows does not support damping; use the solve 'touched'");
    Displacements all_targets = Displacements::Zero(matrix.rows(), 3);  // 0: points that are not moved
    for (size_t i = 0; i < moves.size(); ++i) all_targets.row(moves[i].index) = targets.row(Eigen::Index(i));
    const Displacements moved = pseudoinverseTimes(matrix, all_targets);
    for (size_t i = 0; i < solved.size(); ++i) solved[i] += moved.row(Eigen::Index(i)).transpose();
    return solved;
  }
  std::vector<int> moved_rows;
  for (const Move& move : moves) moved_rows.push_back(move.index);
  if (damping > 0) {
    std::vector<Vec3> displacements;
    for (Eigen::Index i = 0; i < targets.rows(); ++i) displacements.push_back(targets.row(i).transpose());
    const TouchedRowsSolver solver(matrix, moved_rows, damping);
    const std::vector<Vec3> moved = solver.controlDisplacements(displacements);
    for (size_t i = 0; i < solved.size(); ++i) solved[i] += moved[i];
    return solved;
  }
  const TouchedRows touched = touchedRows(matrix, moved_rows);
  const Displacements moved = pseudoinverseTimes(touched.matrix, targets);
  for (size_t i = 0; i < touched.columns.size(); ++i)
    solved[size_t(touched.columns[i])] += moved.row(Eigen::Index(i)).transpose();
  return solved;
}

AllRowsSolver::AllRowsSolver(const StencilMatrix& matrix) {
  if (matrix.cols() > kMaxControlPoints)
    throw Error("a cage of " + std::to_string(matrix.cols()) +
                " control points is too large to sculpt; expected at most " +
                std::to_string(kMaxControlPoints));
  reportProgress(0.0);
  const StencilMatrix transposed = matrix.transpose();
  const Eigen::LLT<MatrixXd> factor{MatrixXd(StencilMatrix(transposed * matrix))};
  if (factor.info() == Eigen::Success && factor.rcond() > kWellConditioned) {
    reportProgress(0.3);  // the inverse takes two thirds of the n³ operations
    gram_inverse_ = factor.solve(MatrixXd::Identity(matrix.cols(), matrix.cols()));
  } else {
    gram_inverse_ = denseGramPseudoinverse(matrix);
  }
  gram_inverse_ = (0.5 * (gram_inverse_ + gram_inverse_.transpose())).eval();  // exactly symmetric
}

std::vector<Vec3> AllRowsSolver::controlDisplacements(const StencilMatrix& matrix,
                                                      const std::vector<Vec3>& data_displacements) const {
  Displacements projected = Displacements::Zero(matrix.cols(), 3);  // Aᵀ (d_new - d)
  for (int row = 0; row < matrix.outerSize(); ++row)
    for (StencilMatrix::InnerIterator entry(matrix, row); entry; ++entry)
      projected.row(entry.col()) += entry.value() * data_displacements[size_t(row)].transpose();
  const Displacements moved = gram_inverse_ * projected;  // (7)
  std::vector<Vec3> displacements(size_t(matrix.cols()));
  for (size_t i = 0; i < displacements.size(); ++i) displacements[i] = moved.row(Eigen::Index(i)).transpose();
  return displacements;
}

}  // namespace airclay
