// SPDX-License-Identifier: MIT
#include "engine/clay/clay_state.h"

#include <cmath>

#include "engine/core/error.h"
#include "engine/mesh/manifold.h"

namespace airclay {

void checkClayState(const ClayState& state, const std::string& where) {
  if (state.levels < 1 || state.levels > kMaxStateLevels)
    throw Error(where + ": subdivision level " + std::to_string(state.levels) + " must be 1 to " +
                std::to_string(kMaxStateLevels));
  const std::vector<Vec3>& points = state.cage.points;
  if (points.size() > kMaxStatePoints)
    throw Error(where + ": " + std::to_string(points.size()) +
                " control points are too many; expected at most " + std::to_string(kMaxStatePoints));
  if (points.size() > std::size_t(state.solve->max_control_points))
    throw Error(where + ": " + std::to_string(points.size()) +
                " control points are too many for the solve '" + state.solve->id +
                "', which supports at most " + std::to_string(state.solve->max_control_points) +
                "; use the solve '" + kSolveTouched.id + "'");
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!points[i].allFinite())
      throw Error(where + ": control point " + std::to_string(i + 1) +
                  " is not finite; expected three numbers in metres");
  if (!(std::abs(state.workspace_from_clay.norm() - 1) < 1e-6))
    throw Error(where + ": the clay's rotation is invalid; expected a unit quaternion");
  std::size_t corners = 0;
  for (const std::vector<int>& face : state.cage.faces) corners += face.size();
  if (corners > kMaxStateCorners)
    throw Error(where + ": the cage's faces have " + std::to_string(corners) + " corners; expected at most " +
                std::to_string(kMaxStateCorners));
  checkCage(state.cage, where);
}

bool sameClay(const ClayState& a, const ClayState& b) {
  return a.levels == b.levels && a.rule == b.rule && a.solve == b.solve && a.cage.points == b.cage.points &&
         a.cage.faces == b.cage.faces && a.workspace_from_clay.coeffs() == b.workspace_from_clay.coeffs();
}

}  // namespace airclay
