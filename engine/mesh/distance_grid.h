// SPDX-License-Identifier: MIT
// Signed distance to a triangle mesh, sampled on a regular grid: how contact asks "inside the hand, how
// deep?".
#pragma once

#include "engine/mesh/mesh.h"

namespace airclay {

/// Samples at the grid's corners; sample (i, j, k) lies at low_corner + cell_m * (i, j, k) and stands in
/// `values` at i + size[0] * (j + size[1] * k). Metres; negative inside.
struct DistanceGrid {
  Vec3 low_corner = Vec3::Zero();
  double cell_m = 0;
  std::array<int, 3> size{};
  std::vector<float> values;
};

/// Of the closed solid withCaps(mesh), `margin_m` wide around it. Distances are exact at the samples (nearest
/// point on the triangles through a bounding volume hierarchy); the sign is that of the generalized winding
/// number (Jacobson et al. 2013), so small self-intersections of a scanned or blended skin do no harm. Uses
/// all cores.
DistanceGrid signedDistanceGrid(const TriangleMesh& mesh, double cell_m, double margin_m);

/// Trilinear interpolation; outside the grid: the nearest border's value plus the distance to the grid.
double sample(const DistanceGrid& grid, const Vec3& point);

/// The exact signed distance of one point to withCaps(mesh), by all triangles: for tests.
double signedDistance(const TriangleMesh& mesh, const Vec3& point);

}  // namespace airclay
