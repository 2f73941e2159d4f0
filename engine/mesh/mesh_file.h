// SPDX-License-Identifier: MIT
// Reads and writes mesh and point cloud files.
#pragma once

#include <filesystem>
#include <vector>

#include "engine/mesh/mesh.h"

namespace airclay {

/// Reads a control cage from an OBJ of polygons, in metres. Points and faces keep the order of the file.
/// \throw Error naming file and line if there is no vertex or face, an index is out of range, a face has
/// fewer than three different corners, or a coordinate is not finite; and like checkCage().
PolygonMesh readObj(const std::filesystem::path& file);

/// Writes `v` and `f` lines with nine significant digits, atomically (a temporary file, renamed).
void writeObj(const std::filesystem::path& file, const PolygonMesh& mesh);
void writeObj(const std::filesystem::path& file, const TriangleMesh& mesh);

/// Writes points as binary little-endian PLY with float x, y, z, atomically.
void writePly(const std::filesystem::path& file, const std::vector<Eigen::Vector3f>& points);

}  // namespace airclay
