// SPDX-License-Identifier: MIT
// Refining: a finer control cage under the same surface, so that detail can be added.
#pragma once

#include "engine/clay/clay_state.h"

namespace airclay {

/// The level-1 points of eq. (3) and (4) become the control points, their quads the cage, and `levels` drops
/// by one. Both rules treat every level alike, so the data points are those of before, to rounding, in
/// another order. At one level there is none to drop: `levels` stays 1 and the polyhedron becomes one step
/// finer. That step goes towards the same limit surface, so the clay looks smoother, and it can be refined
/// again and again. There is no coarsening but undo.
/// \throw Error as subdivide(), or when the control points would be more than `state.solve` takes
/// (AllRowsSolver::kMaxControlPoints for kAll) or than kMaxStatePoints.
ClayState refine(const ClayState& state);

}  // namespace airclay
