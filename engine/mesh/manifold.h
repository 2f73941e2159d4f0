// SPDX-License-Identifier: MIT
// Checks that a polygon mesh is a valid control cage: an orientable 2-manifold, with or without border.
#pragma once

#include <string>

#include "engine/mesh/mesh.h"

namespace airclay {

/// \throw Error starting with `where` (a file, a preset) if a face has fewer than three corners, an index out
/// of range or a repeated point; an edge has more than two faces, or two with opposite orientation; two fans
/// of faces meet only in a point; or a point has no face. Messages count points from 1, as OBJ files do.
void checkCage(const PolygonMesh& cage, const std::string& where);

}  // namespace airclay
