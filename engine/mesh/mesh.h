// SPDX-License-Identifier: MIT
// Polygon and triangle meshes as plain values, and the figures of a solid that they bound.
#pragma once

#include "engine/core/math.h"

namespace airclay {

/// A polygon mesh: control cages and subdivided surfaces. Faces are 0-based point indices,
/// anticlockwise from outside. The order of points and faces is that of the file.
struct PolygonMesh {
  std::vector<Vec3> points;             ///< metres, world
  std::vector<std::vector<int>> faces;  ///< three corners or more each
};

/// A triangle mesh, anticlockwise from outside.
struct TriangleMesh {
  std::vector<Vec3> vertices;  ///< metres
  std::vector<std::array<int, 3>> triangles;
};

/// Volume, centre of gravity and inertia of the solid inside a closed triangle mesh, at unit density
/// (Mirtich 1996, "Fast and accurate computation of polyhedral mass properties": here by signed tetrahedra).
struct MassProperties {
  double volume_m3 = 0;            ///< m in eq. (1), at density 1
  Vec3 centroid = Vec3::Zero();    ///< the volume's, not the vertices' average
  Mat3 inertia_m5 = Mat3::Zero();  ///< about the centroid; I in eq. (2), at density 1
};

/// Of the solid bounded by `mesh`. Boundary loops (an open wrist) are closed by a fan about the loop's
/// average.
MassProperties massProperties(const TriangleMesh& mesh);

/// The mesh with every boundary loop closed by a fan of triangles about the loop's average point.
/// The caps' triangles come after the mesh's own; new vertices after its own.
TriangleMesh withCaps(const TriangleMesh& mesh);

/// Area-weighted unit normals, one a vertex.
std::vector<Vec3> vertexNormals(const TriangleMesh& mesh);

}  // namespace airclay
