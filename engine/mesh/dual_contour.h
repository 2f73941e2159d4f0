// SPDX-License-Identifier: MIT
// An all-quad, closed 2-manifold mesh around the solid inside a closed triangle mesh, by dual contouring.
#pragma once

#include "engine/mesh/lattice_crossings.h"

namespace airclay {

/// Where a point of a net lies on the surface.
enum class Feature : std::uint8_t { kSmooth, kCrease, kCorner };

/// A closed mesh of quads, counterclockwise seen from outside.
struct QuadNet {
  std::vector<Vec3> points;  ///< metres
  std::vector<std::array<int, 4>> quads;
  std::vector<Feature> features;  ///< one per point
};

/// The dual contour of the lattice (Ju, Losasso, Schaefer and Warren 2002, "Dual contouring of Hermite
/// data"), with one vertex per sheet of the surface in a cell (Nielson 2004, "Dual marching cubes"), so that
/// every edge has exactly two faces: where two cells would share two edges, a lattice point between them is
/// added to the solid, until there is no such place. Vertices are the means of their crossings; their
/// features count the directions of the normals there. Parts of the solid without a lattice point are
/// missing. The net is empty if no lattice point is inside. \pre the mesh is closed, within the lattice, two
/// spacings from its sides
QuadNet dualContour(const TriangleMesh& mesh, const Lattice& lattice);

/// A plane through a point on the surface.
struct TangentPlane {
  Vec3 point, normal;
};

/// The minimizer of the squared distances to the planes nearest to `start`. Directions that the planes do not
/// determine stay as in `start`. Sets `feature`.
Vec3 meetingPoint(std::span<const TangentPlane> planes, const Vec3& start, Feature& feature);

/// Merges opposite corners of quads where two points of valence 3 face each other and the other two corners
/// have a valence above 4: on surfaces inclined to the lattice, this turns rhombi into a regular grid
/// (Daniels, Silva, Shepherd and Cohen 2008, "Quadrilateral mesh simplification": quad collapse). The net
/// stays closed and 2-manifold. Corners, and creases that would lose a point, stay.
void collapseRhombi(QuadNet& net);

}  // namespace airclay
