// SPDX-License-Identifier: MIT
// Spreads the points of a net evenly over a surface.
#pragma once

#include "engine/mesh/dual_contour.h"
#include "engine/mesh/triangle_tree.h"

namespace airclay {

/// Moves each point repeatedly towards the area-weighted mean of its quads' centroids, within the surface,
/// and back to the nearest point of `surface` that faces the same way. Then the points nearest to a crease or
/// corner of the surface move there, and the others even out around them; points on creases move only along
/// them. Sets the features. `spacing_m`: the length of the net's edges, about; limits each step.
void spreadEvenly(QuadNet& net, const TriangleTree& surface, double spacing_m);

/// The area vector of a quad: its normal times its area.
Vec3 areaVector(const QuadNet& net, const std::array<int, 4>& quad);

}  // namespace airclay
