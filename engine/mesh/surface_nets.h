// SPDX-License-Identifier: MIT
// From an implicit surface to triangles: surface nets (Gibson 1998, "Constrained elastic surface nets:
// generating smooth surfaces from binary segmented data", MICCAI), with the vertices brought onto the surface
// by Newton steps.
#pragma once

#include <functional>

#include "engine/mesh/mesh.h"

namespace airclay {

/// Negative inside; its size need be a distance only near the surface.
using Implicit = std::function<double(const Vec3&)>;

/// The box that is searched and its cells. The surface must lie inside the box, a cell or more from its
/// sides.
struct NetGrid {
  Vec3 low_corner = Vec3::Zero();
  Vec3 cell = Vec3::Ones();
  std::array<int, 3> cells{};
};

/// A mesh of one vertex a crossed cell, two triangles a crossed edge, anticlockwise from outside; vertices
/// are spread evenly over the surface and lie on it to a few thousandths of a cell. Closed; manifold where no
/// two sheets of the surface cross one cell.
TriangleMesh surfaceNet(const Implicit& surface, const NetGrid& grid);

}  // namespace airclay
