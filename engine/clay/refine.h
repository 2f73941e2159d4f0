// SPDX-License-Identifier: MIT
// Refinement: a finer control cage for the same surface, so that detail can be added.
#pragma once

#include "engine/clay/clay_state.h"

namespace airclay {

/// The level-1 points of eq. (3) and (4) become the control points, their quads the cage, and `levels`
/// decreases by one. Both rules treat every level the same, so the data points stay the same up to rounding,
/// in another order. With one level, `levels` stays 1 and the surface becomes one step finer, towards the
/// same limit surface: it looks smoother, and can be refined repeatedly. The only way back is undo. \throw
/// Error like subdivide(), or if there would be more control points than `state.solve` supports
/// (AllRowsSolver::kMaxControlPoints for kSolveAll) or than kMaxStatePoints.
ClayState refine(const ClayState& state);

}  // namespace airclay
