// SPDX-License-Identifier: MIT
// Clay for other programs: OBJ and PLY for modellers, STL for slicers, glTF for viewers and engines.
#pragma once

#include <array>
#include <filesystem>
#include <string>

#include "engine/mesh/mesh.h"

namespace airclay {

/// The clay's colour on screen (sRGB, 8 bits each) wherever it is drawn or exported.
inline constexpr std::array<int, 3> kClayColor = {170, 150, 137};

/// A channel of an sRGB colour (0 to 255) as linear light, 0 to 1 (IEC 61966-2-1).
float linearFromSrgb(int value);

enum class MeshFormat {
  kObj,  ///< text, polygons kept; metres, z up
  kPly,  ///< binary little endian, polygons kept, smooth normals; metres, z up
  kStl,  ///< binary, triangles; MILLIMETRES, z up, as slicers take it
  kGlb,  ///< glTF 2.0 binary, triangles, smooth normals, one material; metres, y up
};

/// By the file's ending, in capitals or not: .obj, .ply, .stl, .glb. \throw Error (Fault::kUsage) naming the
/// four.
MeshFormat meshFormatOf(const std::filesystem::path& file);

/// What was written.
struct MeshExport {
  MeshFormat format = MeshFormat::kObj;
  std::size_t vertices = 0;    ///< points of the mesh
  std::size_t faces = 0;       ///< in the file: polygons of OBJ and PLY, triangles of STL and glTF
  std::size_t triangles = 0;   ///< that the faces are or would be split into; without those of no area
  std::size_t open_edges = 0;  ///< edges with a triangle on one side only, or two that run along it alike
  Vec3 size_m = Vec3::Zero();  ///< of the box around it, along the world's axes
  double volume_m3 = 0;        ///< inside; each opening closed by a fan; negative: it is inside out

  bool watertight() const { return open_edges == 0; }
};

/// Writes `mesh` (metres, world) in the format that the file's ending says; the file appears whole or not at
/// all. An open mesh is written like any other: the result says so. Points that coincide in STL's precision
/// count as one there, as slicers take it. \throw Error when the ending is none of the four, a face has an
/// index out of range or more than 10,000 corners, a coordinate is beyond 1,000 km or no number, there is no
/// face, or the file cannot be written.
MeshExport exportMesh(const std::filesystem::path& file, const PolygonMesh& mesh);

/// The mesh's faces as triangles, no point added. A quad is split along its shorter diagonal, unless only the
/// other one stays inside; larger polygons by ear clipping (Meisters 1975, "Polygons have ears"), always the
/// ear with the shortest diagonal, in the plane of the polygon's area. \throw Error as exportMesh().
std::vector<std::array<int, 3>> triangulated(const PolygonMesh& mesh);

/// Unit normals, one a point: the area-weighted average of the adjoining faces' normals; straight up where
/// these cancel.
std::vector<Vec3> smoothNormals(const PolygonMesh& mesh);

/// The content of a glTF 2.0 binary with one mesh, `clay`: y up (x, z, -y of the world), metres, a material
/// in kClayColor, seen from both sides when `open`. `normals` are unit and one a vertex.
std::string gltfBinary(const TriangleMesh& mesh, const std::vector<Vec3>& normals, bool open);

}  // namespace airclay
