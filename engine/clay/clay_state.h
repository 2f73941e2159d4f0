// SPDX-License-Identifier: MIT
// Everything about the clay that an edit can change, as one value.
#pragma once

#include <string>

#include "engine/clay/solve.h"
#include "engine/clay/subdivide.h"
#include "engine/mesh/mesh.h"

namespace airclay {

/// The control cage, its subdivision and its solve method.
struct ClayState {
  PolygonMesh cage;  ///< metres, world
  SubdivisionRule rule = SubdivisionRule::kCatmullClark;
  int levels = 2;
  const SolveMethod* solve = &kSolveAll;
  /// The clay frame in the workspace frame. Only the symmetry planes depend on it, which rotate with the
  /// clay; `cage` is in the world frame.
  Eigen::Quaterniond workspace_from_clay = Eigen::Quaterniond::Identity();
};

inline constexpr int kMaxStateLevels = 15;                   ///< the limit of subdivide()
inline constexpr std::size_t kMaxStatePoints = 5'000'000;    ///< the limit of readObj(): 120 MB of points
inline constexpr std::size_t kMaxStateCorners = 20'000'000;  ///< of all faces: as many quads as points

/// \throw Error starting with `where` (a file, a command) if the cage is invalid (engine/mesh/manifold.h) or
/// exceeds the limits above, a coordinate is not finite, `levels` is not 1 to kMaxStateLevels, the rotation
/// is not a unit quaternion, or there are more control points than `solve` supports.
void checkClayState(const ClayState& state, const std::string& where);

/// Whether both are bit for bit equal.
bool sameClay(const ClayState& a, const ClayState& b);

}  // namespace airclay
