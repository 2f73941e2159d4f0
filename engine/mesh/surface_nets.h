// SPDX-License-Identifier: MIT
// Polygonizes an implicit surface by surface nets (Gibson 1998, "Constrained elastic surface nets: generating
// smooth surfaces from binary segmented data", MICCAI), with vertices projected onto the surface by Newton
// steps.
#pragma once

#include <functional>

#include "engine/mesh/mesh.h"

namespace airclay {

/// A function that is negative inside, and approximates the signed distance near the surface.
using Implicit = std::function<double(const Vec3&)>;

/// The grid to search. The surface must be inside it, at least one cell from its sides.
struct NetGrid {
  Vec3 low_corner = Vec3::Zero();
  Vec3 cell = Vec3::Ones();
  std::array<int, 3> cells{};
};

/// A closed mesh with one vertex per crossed cell and two triangles per crossed edge, counterclockwise seen
/// from outside. Vertices are evenly spaced and within a few thousandths of a cell of the surface. Manifold
/// wherever no cell is crossed by two sheets of the surface.
TriangleMesh surfaceNet(const Implicit& surface, const NetGrid& grid);

}  // namespace airclay
