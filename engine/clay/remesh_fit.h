// SPDX-License-Identifier: MIT
// The last steps of remeshing: control points for given surface points, and the distance that remains.
#pragma once

#include "engine/clay/subdivide.h"
#include "engine/mesh/triangle_tree.h"

namespace airclay {

/// Control points whose surface at level 2 passes close to `targets` (one per control point) and encloses
/// `volume_m3`. `subdivision`: two levels of a closed cage. Corrections of the volume move no point by more
/// than a tenth of `spacing_m`.
std::vector<Vec3> controlPointsThrough(const Subdivision& subdivision, std::vector<Vec3> targets,
                                       double volume_m3, double spacing_m);

/// Moves the control points so that the surface also comes closer to samples of `surface` that are farther
/// than `tolerance_m` from it, at sharp edges, which it cuts; then encloses `volume_m3`. `step_m`: between
/// samples. Uses all cores.
void approachSamples(const Subdivision& subdivision, const std::vector<Triangle>& surface, double step_m,
                     double tolerance_m, double volume_m3, std::vector<Vec3>& control_points);

/// The largest distance from a sample of one surface to the other, both ways. Samples: the vertices of
/// `mesh`, and centroids of `surface` split into triangles with edges of at most `step_m`. Uses all cores.
double hausdorffDistance(const std::vector<Triangle>& surface, const TriangleMesh& mesh, double step_m);

}  // namespace airclay
