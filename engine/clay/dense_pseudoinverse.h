// SPDX-License-Identifier: MIT
// The pseudoinverse of an ill-conditioned A from singular values, for the solves that Cholesky cannot do.
#pragma once

#include "engine/clay/subdivide.h"

namespace airclay {

/// A⁺ b, exact Moore-Penrose: the smallest of all best-fitting x, singular values truncated at
/// kSingularCutoff. `right_side` has 3 columns. \throw Error if the singular values do not converge.
Eigen::MatrixXd densePseudoinverseTimes(const StencilMatrix& matrix, const Eigen::MatrixXd& right_side);

/// (AᵀA)⁺ = V Σ⁺² Vᵀ, from the singular values of A itself; symmetric. \throw Error likewise.
Eigen::MatrixXd denseGramPseudoinverse(const StencilMatrix& matrix);

}  // namespace airclay
