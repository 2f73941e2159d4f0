// SPDX-License-Identifier: MIT
// A mesh as stored in a file, before any repair: one parser per format.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "engine/mesh/mesh.h"

namespace airclay {

constexpr std::size_t kMaxMeshFileBytes = std::size_t(256) << 20;  // text of 5 million points and their faces
constexpr std::size_t kMaxMeshPoints = 5'000'000;
constexpr std::size_t kMaxMeshCorners = 20'000'000;  // as many quads as points

/// Points and faces in the order, units and axes of the file.
struct MeshSource {
  std::string format;                   ///< for people: "PLY, binary little endian"
  std::vector<Vec3> points;             ///< finite
  std::vector<std::vector<int>> faces;  ///< valid indices; the same one may occur twice in a face
  std::vector<long> face_lines;         ///< the line of each face, from 1; empty for binary formats
  std::size_t loose_edges = 0;          ///< edges without a face that the file lists
  std::vector<std::string> notes;       ///< repairs by the parser, one line each
};

/// A file's content, and its name for messages.
struct MeshFileContent {
  const std::string& name;
  std::string_view bytes;
};

/// Whether a corner may occur twice in a face.
enum class RepeatedCorners { kRefuse, kKeep };

// Each throws Error that names the file and the line or byte. Memory is bounded by the content's size.
MeshSource parseObj(const MeshFileContent& file, RepeatedCorners repeated);
MeshSource parsePly(const MeshFileContent& file);
/// Corners at the same position become one point: STL stores each triangle's corners separately.
MeshSource parseStl(const MeshFileContent& file);
/// The scene's meshes in scene coordinates; vertices at the same position become one point, because glTF
/// splits them at seams. A .gltf may read buffers from `folder`.
MeshSource parseGltf(const MeshFileContent& file, const std::filesystem::path& folder);

}  // namespace airclay
