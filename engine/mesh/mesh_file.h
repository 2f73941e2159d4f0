// SPDX-License-Identifier: MIT
// Meshes and point clouds in files.
#pragma once

#include <filesystem>
#include <vector>

#include "engine/mesh/mesh.h"

namespace airclay {

/// Reads an OBJ of polygons: a control cage. Order of points and faces as in the file; metres.
/// \throw Error naming file and line: no vertex or face, an index out of range, a face of fewer than three
/// different corners, a coordinate that is no finite number; or naming the two points of an edge that is
/// non-manifold (more than two faces, or two faces that run along it the same way), or the point where two
/// fans of faces touch, or a point without a face.
PolygonMesh readObj(const std::filesystem::path& file);

/// Writes `v` and `f` lines, nine significant digits. The file appears whole or not at all (written beside,
/// renamed).
void writeObj(const std::filesystem::path& file, const PolygonMesh& mesh);
void writeObj(const std::filesystem::path& file, const TriangleMesh& mesh);

/// Writes points as binary little-endian PLY with float x, y, z. The file appears whole or not at all.
void writePly(const std::filesystem::path& file, const std::vector<Eigen::Vector3f>& points);

}  // namespace airclay
