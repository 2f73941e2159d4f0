// SPDX-License-Identifier: MIT
// Everything about the clay that an edit can change, as one plain value.
#pragma once

#include <string>

#include "engine/clay/solve.h"
#include "engine/clay/subdivide.h"
#include "engine/mesh/mesh.h"

namespace airclay {

/// The control cage, and how it is subdivided and solved.
struct ClayState {
  PolygonMesh cage;  ///< metres, world
  SubdivisionRule rule = SubdivisionRule::kCatmullClark;
  int levels = 2;
  const SolveMethod* solve = &kSolveAll;
  /// How the clay's own frame stands in the workspace's: the planes of symmetry are the clay's, and turn with
  /// it. Where the control points are, `cage` says alone.
  Eigen::Quaterniond workspace_from_clay = Eigen::Quaterniond::Identity();
};

inline constexpr int kMaxStateLevels = 15;                   ///< subdivide()'s most
inline constexpr std::size_t kMaxStatePoints = 5'000'000;    ///< readObj()'s most: 120 MB of control points
inline constexpr std::size_t kMaxStateCorners = 20'000'000;  ///< of all faces: as many quads as points

/// \throw Error that begins with `where` (a file, a command) when the cage is none (engine/mesh/manifold.h)
/// or larger than the limits above, a coordinate is not finite, `levels` is not 1 to kMaxStateLevels, the
/// turn is no unit quaternion, or there are more control points than `solve` takes.
void checkClayState(const ClayState& state, const std::string& where);

/// Bit for bit the same clay.
bool sameClay(const ClayState& a, const ClayState& b);

}  // namespace airclay
