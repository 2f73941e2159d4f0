// SPDX-License-Identifier: MIT
// The content of small valid mesh files in every format that is read as a cage.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "engine/mesh/mesh.h"

namespace airclay {

/// A cube of `size`, its corners from the origin on, anticlockwise from outside.
PolygonMesh cubeCage(double size);

enum class PlyEncoding { kText, kLittleEndian, kBigEndian };

std::string objOf(const PolygonMesh& mesh);
/// With normals, colours, an edge and an element that readers must skip.
std::string plyOf(const PolygonMesh& mesh, PlyEncoding encoding);
/// Quads are split.
std::string stlTextOf(const PolygonMesh& mesh);
std::string stlBinaryOf(const PolygonMesh& mesh, const std::string& header = "a binary STL");
/// Quads are split, each face has vertices of its own; the numbers are written as they are. With its buffer
/// as a data URI, or in the file `buffer_uri`, which gltfBuffer() gives.
std::string gltfOf(const PolygonMesh& mesh, const std::string& buffer_uri = "");
std::string gltfBuffer(const PolygonMesh& mesh);
std::string glbOf(const PolygonMesh& mesh);

/// The mesh as a file of each kind: its name and its content.
std::vector<std::pair<std::string, std::string>> cageFiles(const PolygonMesh& mesh);

}  // namespace airclay
