// SPDX-License-Identifier: MIT
#include "engine/mesh/thicken.h"

#include <algorithm>

namespace airclay {

TriangleMesh thickened(const TriangleMesh& sheet, double thickness_m) {
  const std::vector<Vec3> normals = vertexNormals(sheet);
  const int count = int(sheet.vertices.size());
  TriangleMesh solid;
  for (const double side : {0.5, -0.5})
    for (std::size_t v = 0; v < sheet.vertices.size(); ++v)
      solid.vertices.push_back(sheet.vertices[v] + side * thickness_m * normals[v]);
  std::vector<std::pair<int, int>> edges;
  for (const auto& [a, b, c] : sheet.triangles) {
    solid.triangles.push_back({a, b, c});
    solid.triangles.push_back({count + a, count + c, count + b});
    for (const auto& edge : {std::pair{a, b}, {b, c}, {c, a}}) edges.push_back(edge);
  }
  std::sort(edges.begin(), edges.end());
  for (const auto& [a, b] : edges) {
    if (std::binary_search(edges.begin(), edges.end(), std::pair{b, a})) continue;
    solid.triangles.push_back({b, a, count + a});
    solid.triangles.push_back({b, count + a, count + b});
  }
  return solid;
}

}  // namespace airclay
