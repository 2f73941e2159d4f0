// SPDX-License-Identifier: MIT
// The damped solve over the touched rows only, on the host.
#include <algorithm>
#include <optional>

#include "engine/clay/solve.h"
#include "engine/clay/touched_rows.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

using Eigen::MatrixXd;
using Displacements = Eigen::Matrix<double, Eigen::Dynamic, 3>;  ///< one per row, metres

class TouchedSolver final : public ClaySolver {
 public:
  explicit TouchedSolver(const StencilMatrix& matrix) : matrix_(matrix) {}

  bool onDevice() const override { return false; }
  std::vector<Vec3> controlDisplacements(const std::vector<int>& rows,
                                         const std::vector<Vec3>& displacements) override {
    if (!solver_ || solver_->rows() != rows) solver_.emplace(matrix_, rows, kTouchedDamping);
    return solver_->controlDisplacements(displacements);
  }

 private:
  const StencilMatrix& matrix_;
  std::optional<TouchedRowsSolver> solver_;  ///< for the rows of the last call
};

std::unique_ptr<ClaySolver> createTouchedSolver(Gpu&, const StencilMatrix& matrix) {
  return std::make_unique<TouchedSolver>(matrix);
}

}  // namespace

const SolveMethod kSolveTouched = {
    .id = "touched",
    .name = "Touched points",
    .description = "fits only the data points that the hand moved; the others follow",
    .fits_unmoved = false,
    .max_control_points = 5'000'000,
    .create = createTouchedSolver,
};

TouchedRows touchedRows(const StencilMatrix& matrix, const std::vector<int>& rows) {
  TouchedRows touched;
  for (const int row : rows)
    for (StencilMatrix::InnerIterator entry(matrix, row); entry; ++entry)
      touched.columns.push_back(int(entry.col()));
  std::sort(touched.columns.begin(), touched.columns.end());
  touched.columns.erase(std::unique(touched.columns.begin(), touched.columns.end()), touched.columns.end());

  std::vector<Eigen::Triplet<double>> weights;
  for (size_t i = 0; i < rows.size(); ++i)
    for (StencilMatrix::InnerIterator entry(matrix, rows[i]); entry; ++entry) {
      const auto column = std::lower_bound(touched.columns.begin(), touched.columns.end(), int(entry.col()));
      weights.emplace_back(int(i), int(column - touched.columns.begin()), entry.value());
    }
  touched.matrix.resize(Eigen::Index(rows.size()), Eigen::Index(touched.columns.size()));
  touched.matrix.setFromTriplets(weights.begin(), weights.end());
  return touched;
}

TouchedRowsSolver::TouchedRowsSolver(const StencilMatrix& matrix, const std::vector<int>& rows,
                                     double damping)
    : control_point_count_(int(matrix.cols())), rows_(rows) {
  TouchedRows touched = touchedRows(matrix, rows);
  columns_ = std::move(touched.columns);
  touched_ = std::move(touched.matrix);
  more_rows_ = touched_.rows() > touched_.cols();
  if (const Eigen::Index size = std::min(touched_.rows(), touched_.cols());
      size > AllRowsSolver::kMaxControlPoints)
    throw Error("the damped solve over " + std::to_string(size) +
                " control points is too large; expected at most " +
                std::to_string(AllRowsSolver::kMaxControlPoints));
  // (AᵀA + λ²I)⁻¹Aᵀ b = Aᵀ(AAᵀ + λ²I)⁻¹ b: whichever matrix is smaller
  const StencilMatrix transposed = touched_.transpose();
  MatrixXd gram = more_rows_ ? MatrixXd(StencilMatrix(transposed * touched_))
                             : MatrixXd(StencilMatrix(touched_ * transposed));
  gram.diagonal().array() += damping * damping;
  factor_.compute(gram);
}

std::vector<Vec3> TouchedRowsSolver::controlDisplacements(const std::vector<Vec3>& row_displacements) const {
  Displacements targets(touched_.rows(), 3);
  for (size_t i = 0; i < row_displacements.size(); ++i)
    targets.row(Eigen::Index(i)) = row_displacements[i].transpose();
  const MatrixXd moved = more_rows_ ? MatrixXd(factor_.solve(MatrixXd(touched_.transpose() * targets)))
                                    : MatrixXd(touched_.transpose() * MatrixXd(factor_.solve(targets)));
  std::vector<Vec3> displacements(size_t(control_point_count_), Vec3::Zero());
  for (size_t i = 0; i < columns_.size(); ++i)
    displacements[size_t(columns_[i])] = moved.row(Eigen::Index(i)).transpose();
  return displacements;
}

}  // namespace airclay
