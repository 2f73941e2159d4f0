// SPDX-License-Identifier: MIT
#include "tests/support/solids.h"

#include <cmath>
#include <map>
#include <numbers>
#include <set>

namespace airclay {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

}  // namespace

TriangleMesh gridSurface(int u_count, int v_count, const std::function<Vec3(double, double)>& point) {
  TriangleMesh mesh;
  for (int u = 0; u < u_count; ++u)
    for (int v = 0; v < v_count; ++v)
      mesh.vertices.push_back(point(double(u) / u_count, double(v) / v_count));
  for (int u = 0; u < u_count; ++u)
    for (int v = 0; v < v_count; ++v) {
      const int next_u = (u + 1) % u_count, next_v = (v + 1) % v_count;
      const int a = u * v_count + v, b = next_u * v_count + v, c = next_u * v_count + next_v,
                d = u * v_count + next_v;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  return mesh;
}

TriangleMesh torusMesh(double major_radius, double minor_radius, int u_count, int v_count) {
  return gridSurface(u_count, v_count, [&](double u, double v) {
    const double around = kTurn * u, across = kTurn * v;
    const double distance = major_radius + minor_radius * std::cos(across);
    return Vec3(distance * std::cos(around), distance * std::sin(around), minor_radius * std::sin(across));
  });
}

TriangleMesh sphereMesh(double radius, int levels) {
  TriangleMesh mesh;
  mesh.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::vector<std::array<int, 3>> finer;
    std::map<std::pair<int, int>, int> middles;  // of an edge: shared, otherwise the mesh would be open
    for (const auto& t : mesh.triangles) {
      std::array<int, 3> middle{};
      for (int i = 0; i < 3; ++i) {
        const int a = t[i], b = t[(i + 1) % 3];
        const auto [known, is_new] = middles.try_emplace(std::minmax({a, b}), int(mesh.vertices.size()));
        if (is_new) mesh.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]).normalized());
        middle[i] = known->second;
      }
      finer.push_back({t[0], middle[0], middle[2]});
      finer.push_back({middle[0], t[1], middle[1]});
      finer.push_back({middle[2], middle[1], t[2]});
      finer.push_back(middle);
    }
    mesh.triangles = finer;
  }
  for (Vec3& vertex : mesh.vertices) vertex *= radius;
  return mesh;
}

TriangleMesh ballMesh(const Vec3& center, double radius, int levels) {
  TriangleMesh mesh = sphereMesh(1, levels);
  const double volume = massProperties(mesh).volume_m3;
  const double scale = radius * std::cbrt(4 * std::numbers::pi / 3 / volume);
  for (Vec3& vertex : mesh.vertices) vertex = center + scale * vertex;
  return mesh;
}

TriangleMesh boxMesh(const Vec3& half) {
  TriangleMesh mesh;
  for (int corner = 0; corner < 8; ++corner)
    mesh.vertices.push_back(
        half.cwiseProduct(Vec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1)));
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

Vec3 figureEightCurve(double scale, double t) {
  return scale * Vec3(std::sin(t), std::sin(t) * std::cos(t), 0);
}

TriangleMesh figureEightMesh(double scale, double radius, int u_count, int v_count) {
  return gridSurface(u_count, v_count, [&](double u, double v) {
    const double t = kTurn * u, across = kTurn * v;
    const Vec3 along = Vec3(std::cos(t), std::cos(2 * t), 0).normalized(), up = Vec3::UnitZ();
    return Vec3(figureEightCurve(scale, t) +
                radius * (std::cos(across) * along.cross(up) + std::sin(across) * up));
  });
}

TriangleMesh together(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh both = a;
  const int first = int(a.vertices.size());
  both.vertices.insert(both.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& [i, j, k] : b.triangles) both.triangles.push_back({first + i, first + j, first + k});
  return both;
}

int eulerCharacteristic(const PolygonMesh& mesh) {
  std::set<std::pair<int, int>> edges;
  for (const std::vector<int>& face : mesh.faces)
    for (std::size_t k = 0; k < face.size(); ++k)
      edges.insert(std::minmax(face[k], face[(k + 1) % face.size()]));
  return int(mesh.points.size()) - int(edges.size()) + int(mesh.faces.size());
}

}  // namespace airclay
