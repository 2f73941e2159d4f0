// SPDX-License-Identifier: MIT
// Closed triangle meshes of shapes whose volume and distances are known in closed form.
#pragma once

#include <functional>

#include "engine/mesh/mesh.h"

namespace airclay {

/// A surface over the torus [0, 1) x [0, 1): `point(u, v)`, with u x v outwards.
TriangleMesh gridSurface(int u_count, int v_count, const std::function<Vec3(double u, double v)>& point);

TriangleMesh torusMesh(double major_radius, double minor_radius, int u_count, int v_count);

/// An octahedron subdivided `levels` times, its vertices on the sphere about the origin.
TriangleMesh sphereMesh(double radius, int levels);

/// The same about `center`; its vertices are outside the sphere by so much that its volume is the ball's.
TriangleMesh ballMesh(const Vec3& center, double radius, int levels);

TriangleMesh boxMesh(const Vec3& half);

/// A tube of `radius` around the curve (scale sin t, scale sin t cos t, 0), which crosses itself at the
/// origin at a right angle.
TriangleMesh figureEightMesh(double scale, double radius, int u_count, int v_count);
Vec3 figureEightCurve(double scale, double t);

/// Both meshes' triangles, without shared vertices.
TriangleMesh together(const TriangleMesh& a, const TriangleMesh& b);

/// Vertices minus edges plus faces: 2 for a sphere, 0 for a torus; the sum over all parts.
int eulerCharacteristic(const PolygonMesh& mesh);

}  // namespace airclay
