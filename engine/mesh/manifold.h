// SPDX-License-Identifier: MIT
// What makes a polygon mesh a control cage: an orientable 2-manifold, with or without border.
#pragma once

#include <string>

#include "engine/mesh/mesh.h"

namespace airclay {

/// \throw Error that begins with `where` (a file, a preset) when a face has fewer than three corners, an
/// index out of range or the same point twice; an edge has more than two faces or two that run along it the
/// same way; two fans of faces touch in a point; or a point has no face. Points are counted from 1 in the
/// message, as in an OBJ.
void checkCage(const PolygonMesh& cage, const std::string& where);

}  // namespace airclay
