// SPDX-License-Identifier: MIT
// Mass properties, caps and normals of triangle meshes.
#include "engine/mesh/mesh.h"

#include <map>
#include <utility>

namespace airclay {
namespace {

/// Start and end of each border edge, in the direction of its triangle; an edge occurs once per unmatched
/// triangle. At every vertex the numbers of incoming and outgoing border edges are equal, because each
/// triangle is a closed walk.
std::multimap<int, int> borderEdges(const TriangleMesh& mesh) {
  std::map<std::pair<int, int>, int> surplus;  // (a, b), a < b: edges from a to b minus edges from b to a
  for (const auto& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      const int a = triangle[i], b = triangle[(i + 1) % 3];
      if (a < b) ++surplus[{a, b}];
      if (b < a) --surplus[{b, a}];
    }
  }
  std::multimap<int, int> border;
  for (const auto& [edge, count] : surplus) {
    for (int i = 0; i < count; ++i) border.emplace(edge.first, edge.second);
    for (int i = 0; i < -count; ++i) border.emplace(edge.second, edge.first);
  }
  return border;
}

}  // namespace

TriangleMesh withCaps(const TriangleMesh& mesh) {
  TriangleMesh closed = mesh;
  std::multimap<int, int> border = borderEdges(mesh);
  while (!border.empty()) {
    const int start = border.begin()->first;
    std::vector<int> loop;
    for (int vertex = start; loop.empty() || vertex != start;) {
      loop.push_back(vertex);
      const auto edge = border.find(vertex);
      vertex = edge->second;
      border.erase(edge);
    }
    Vec3 average = Vec3::Zero();
    for (const int vertex : loop) average += mesh.vertices[vertex] / double(loop.size());
    const int hub = int(closed.vertices.size());
    closed.vertices.push_back(average);
    for (size_t i = 0; i < loop.size(); ++i)
      closed.triangles.push_back({loop[(i + 1) % loop.size()], loop[i], hub});
  }
  return closed;
}

MassProperties massProperties(const TriangleMesh& mesh) {
  const TriangleMesh closed = withCaps(mesh);
  MassProperties mass;
  if (closed.triangles.empty()) return mass;
  // Tetrahedra with a corner near the solid: a distant origin would cause cancellation.
  const Vec3 origin = closed.vertices[closed.triangles[0][0]];
  Vec3 first_moment = Vec3::Zero();
  Mat3 second_moment = Mat3::Zero();  // the integral of x xᵀ about `origin`
  for (const auto& triangle : closed.triangles) {
    const Vec3 a = closed.vertices[triangle[0]] - origin;
    const Vec3 b = closed.vertices[triangle[1]] - origin;
    const Vec3 c = closed.vertices[triangle[2]] - origin;
    const double volume = a.dot(b.cross(c)) / 6;
    const Vec3 sum = a + b + c;
    mass.volume_m3 += volume;
    first_moment += volume / 4 * sum;
    second_moment +=
        volume / 20 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  if (mass.volume_m3 == 0) return mass;
  const Vec3 center = first_moment / mass.volume_m3;
  second_moment -= mass.volume_m3 * center * center.transpose();
  mass.centroid = origin + center;
  mass.inertia_m5 = second_moment.trace() * Mat3::Identity() - second_moment;
  return mass;
}

std::vector<Vec3> vertexNormals(const TriangleMesh& mesh) {
  std::vector<Vec3> normals(mesh.vertices.size(), Vec3::Zero());
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 twice_area = (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]);
    for (const int vertex : {a, b, c}) normals[vertex] += twice_area;
  }
  for (Vec3& normal : normals) normal.normalize();  // Eigen does not change a zero vector
  return normals;
}

}  // namespace airclay
