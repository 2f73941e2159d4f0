// SPDX-License-Identifier: MIT
// Exports clay for other programs: OBJ and PLY for modelling, STL for slicers, glTF for viewers and engines.
#pragma once

#include <array>
#include <filesystem>
#include <string>

#include "engine/mesh/mesh.h"

namespace airclay {

/// The clay's colour (sRGB, 8 bits per channel) in images and exports.
inline constexpr std::array<int, 3> kClayColor = {170, 150, 137};

/// The linear value, 0 to 1, of an sRGB channel, 0 to 255 (IEC 61966-2-1).
float linearFromSrgb(int value);

enum class MeshFormat {
  kObj,  ///< text, polygons; metres, z up
  kPly,  ///< binary little endian, polygons, smooth normals; metres, z up
  kStl,  ///< binary, triangles; MILLIMETRES, z up, as slicers expect
  kGlb,  ///< glTF 2.0 binary, triangles, smooth normals, one material; metres, y up
};

/// The format for a file's extension, in any case: .obj, .ply, .stl, .glb. \throw Error (Fault::kUsage) for
/// others
MeshFormat meshFormatOf(const std::filesystem::path& file);

/// Statistics of an exported mesh.
struct MeshExport {
  MeshFormat format = MeshFormat::kObj;
  std::size_t vertices = 0;    ///< points of the mesh
  std::size_t faces = 0;       ///< in the file: polygons in OBJ and PLY, triangles in STL and glTF
  std::size_t triangles = 0;   ///< of the triangulated mesh, without those of zero area
  std::size_t open_edges = 0;  ///< edges with one triangle, or with two of opposite orientation
  Vec3 size_m = Vec3::Zero();  ///< of the bounding box, along the world's axes
  double volume_m3 = 0;        ///< of withCaps(); negative if the mesh is inside out

  bool watertight() const { return open_edges == 0; }
};

/// Writes `mesh` (metres, world) in the format of the file's extension, atomically. Open meshes are written
/// too; see the result. `open_edges` treats points that coincide in STL's precision as one, as slicers do.
/// \throw Error if the extension is unknown, there is no face, a face has an index out of range or more than
/// 10,000 corners, a coordinate is beyond 1,000 km or not finite, or the file cannot be written.
MeshExport exportMesh(const std::filesystem::path& file, const PolygonMesh& mesh);

/// The mesh's faces as triangles, without new points. A quad is split along its shorter diagonal, unless only
/// the longer one is inside; larger polygons by ear clipping (Meisters 1975, "Polygons have ears") in the
/// plane of the polygon's area vector, always at the ear with the shortest diagonal. \throw Error if a face
/// has more than 10,000 corners.
std::vector<std::array<int, 3>> triangulated(const PolygonMesh& mesh);

/// Unit normals, one per point: the area-weighted average of the adjoining faces' normals; +z where these
/// cancel out.
std::vector<Vec3> smoothNormals(const PolygonMesh& mesh);

/// The content of a glTF 2.0 binary with one mesh, `clay`: y up (x, z, -y of the world), metres, a material
/// in kClayColor, double-sided if `open`. `normals`: unit, one per vertex.
std::string gltfBinary(const TriangleMesh& mesh, const std::vector<Vec3>& normals, bool open);

}  // namespace airclay
