// SPDX-License-Identifier: MIT
// Polygon and triangle meshes as plain values, and the mass properties of the solids that they bound.
#pragma once

#include "engine/core/math.h"

namespace airclay {

/// A polygon mesh: a control cage or a subdivided surface. Faces are 0-based point indices, counterclockwise
/// seen from outside. Points and faces keep the order of their file.
struct PolygonMesh {
  std::vector<Vec3> points;             ///< metres, world
  std::vector<std::vector<int>> faces;  ///< at least three corners each
};

/// A triangle mesh, counterclockwise seen from outside.
struct TriangleMesh {
  std::vector<Vec3> vertices;  ///< metres
  std::vector<std::array<int, 3>> triangles;
};

/// Volume, centroid and inertia of the solid inside a closed triangle mesh, at unit density, by signed
/// tetrahedra (see Mirtich 1996, "Fast and accurate computation of polyhedral mass properties").
struct MassProperties {
  double volume_m3 = 0;            ///< m in eq. (1), at density 1
  Vec3 centroid = Vec3::Zero();    ///< of the volume, not of the vertices; metres
  Mat3 inertia_m5 = Mat3::Zero();  ///< about the centroid; I in eq. (2), at density 1
};

/// The mass properties of the solid bounded by withCaps(mesh).
MassProperties massProperties(const TriangleMesh& mesh);

/// The mesh with every boundary loop (an open wrist) closed by a fan of triangles around the loop's mean
/// point. New triangles and vertices follow the mesh's own.
TriangleMesh withCaps(const TriangleMesh& mesh);

/// Area-weighted unit normals, one per vertex.
std::vector<Vec3> vertexNormals(const TriangleMesh& mesh);

}  // namespace airclay
