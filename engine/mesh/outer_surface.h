// SPDX-License-Identifier: MIT
// The surface of the union of overlapping solids.
#pragma once

#include "engine/mesh/triangle_tree.h"

namespace airclay {

/// The parts of a closed mesh that separate outside (winding number 0) from inside (1): the surface of the
/// union of overlapping or self-overlapping parts. Triangles where it intersects itself are split until their
/// edges are shorter than detail_m / 5, and kept or dropped whole; others stay as they are, unless their
/// edges are longer than `detail_m`. Uses all cores.
std::vector<Triangle> outerTriangles(const TriangleMesh& mesh, double detail_m);

}  // namespace airclay
