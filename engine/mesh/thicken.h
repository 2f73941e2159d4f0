// SPDX-License-Identifier: MIT
// Turns an open sheet into a closed solid.
#pragma once

#include "engine/mesh/mesh.h"

namespace airclay {

/// The sheet moved by half of `thickness_m` along its vertex normals to either side, and walls along its
/// borders. Closed if the sheet's triangles agree in orientation. Where the sheet's radius of curvature is
/// less than half the thickness, the solid overlaps itself.
TriangleMesh thickened(const TriangleMesh& sheet, double thickness_m);

}  // namespace airclay
