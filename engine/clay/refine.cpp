// SPDX-License-Identifier: MIT
#include "engine/clay/refine.h"

#include <algorithm>

#include "engine/core/error.h"

namespace airclay {

ClayState refine(const ClayState& state) {
  const Subdivision step = subdivide(state.cage, 1, state.rule);
  const std::size_t limit = std::min(std::size_t(state.solve->max_control_points), kMaxStatePoints);
  if (static_cast<std::size_t>(step.matrix.rows()) > limit)
    throw Error("refining turns " + std::to_string(state.cage.points.size()) + " control points into " +
                std::to_string(step.matrix.rows()) + "; expected at most " + std::to_string(limit) +
                (state.solve->fits_unmoved ? " for this solve; the solve 'touched' supports more" : ""));
  ClayState refined;
  refined.cage.points = dataPoints(step.matrix, state.cage.points);
  for (const std::array<int, 4>& quad : step.quads) refined.cage.faces.emplace_back(quad.begin(), quad.end());
  refined.rule = state.rule;
  refined.levels = std::max(state.levels - 1, 1);
  refined.solve = state.solve;
  refined.workspace_from_clay = state.workspace_from_clay;
  return refined;
}

}  // namespace airclay
