// SPDX-License-Identifier: MIT
// The signed distance to a triangle mesh, sampled on a regular grid. Contact uses it to find how deep a point
// is inside the hand.
#pragma once

#include "engine/mesh/mesh.h"

namespace airclay {

/// Samples at the grid's corners. Sample (i, j, k) is at low_corner + cell_m * (i, j, k), with index
/// i + size[0] * (j + size[1] * k) in `values`. Metres, in the mesh's frame; negative inside.
struct DistanceGrid {
  Vec3 low_corner = Vec3::Zero();
  double cell_m = 0;
  std::array<int, 3> size{};
  std::vector<float> values;
};

/// The distance to the closed solid withCaps(mesh), with a margin of `margin_m` around it. Distances are
/// exact at the samples (nearest point on the triangles, by a bounding volume hierarchy); the sign is that of
/// the generalized winding number (Jacobson et al. 2013), which tolerates small self-intersections of a
/// scanned or skinned mesh. Uses all cores. \throw Error if the mesh has no triangles or the grid would be
/// too large.
DistanceGrid signedDistanceGrid(const TriangleMesh& mesh, double cell_m, double margin_m);

/// Trilinear interpolation, metres; outside the grid, the value at the nearest border point plus the distance
/// to it.
double sample(const DistanceGrid& grid, const Vec3& point);

/// The exact signed distance of one point to withCaps(mesh), over all triangles; for tests.
double signedDistance(const TriangleMesh& mesh, const Vec3& point);

}  // namespace airclay
