// SPDX-License-Identifier: MIT
// Householder reflections reduce A to a small triangle, which is solved by its singular values. In a file of
// its own, because Eigen's singular values take over 20 seconds to compile.
#include "engine/clay/dense_pseudoinverse.h"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>

#include "engine/clay/solve.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

using Eigen::MatrixXd;

// Factoring this many rows at a time limits the memory for a tall, narrow matrix.
constexpr int kBlockRows = 2048;

/// The least-squares problem min |A x - b| reduced to fewer rows: R and Qᵀb of A = Q R.
struct ReducedRows {
  MatrixXd triangle;    ///< min(m, n) x n
  MatrixXd right_side;  ///< the same number of rows; no columns without b
};

/// Householder QR, one row block at a time.
ReducedRows reduceRows(const StencilMatrix& matrix, const MatrixXd& right_side) {
  const Eigen::Index n = matrix.cols(), k = right_side.cols();
  MatrixXd reduced(0, n + k);  // [R, Qᵀb] of the rows so far
  for (Eigen::Index first = 0; first < matrix.rows(); first += kBlockRows) {
    const Eigen::Index count = std::min<Eigen::Index>(kBlockRows, matrix.rows() - first);
    MatrixXd stacked(reduced.rows() + count, n + k);
    stacked.topRows(reduced.rows()) = reduced;
    stacked.bottomRows(count).leftCols(n) = MatrixXd(matrix.middleRows(first, count));
    stacked.bottomRows(count).rightCols(k) = right_side.middleRows(first, count);
    const Eigen::Index rank = std::min(stacked.rows(), n);
    MatrixXd left = stacked.leftCols(n);
    const Eigen::HouseholderQR<Eigen::Ref<MatrixXd>> qr(left);
    reduced.resize(rank, n + k);
    reduced.leftCols(n) = qr.matrixQR().topRows(rank).triangularView<Eigen::Upper>();
    reduced.rightCols(k) = (qr.householderQ().adjoint() * stacked.rightCols(k)).topRows(rank);
  }
  return {reduced.leftCols(n), reduced.rightCols(k)};
}

Eigen::BDCSVD<MatrixXd> singularValues(const MatrixXd& matrix) {
  Eigen::BDCSVD<MatrixXd> svd(matrix, Eigen::ComputeThinU | Eigen::ComputeThinV);
  if (svd.info() != Eigen::Success)
    throw Error("the solve's singular values did not converge; is a control point NaN?");
  svd.setThreshold(kSingularCutoff);  // relative to the largest; applies to rank() too
  return svd;
}

}  // namespace

MatrixXd densePseudoinverseTimes(const StencilMatrix& matrix, const MatrixXd& right_side) {
  const ReducedRows reduced = reduceRows(matrix, right_side);
  return singularValues(reduced.triangle).solve(reduced.right_side);
}

MatrixXd denseGramPseudoinverse(const StencilMatrix& matrix) {
  const auto svd = singularValues(reduceRows(matrix, MatrixXd(matrix.rows(), 0)).triangle);
  const MatrixXd scaled =
      svd.matrixV().leftCols(svd.rank()) * svd.singularValues().head(svd.rank()).cwiseInverse().asDiagonal();
  return scaled * scaled.transpose();
}

}  // namespace airclay
