// SPDX-License-Identifier: MIT
#include "engine/mesh/outer_surface.h"

#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"

namespace airclay {
namespace {

constexpr double kAbove = 1e-3;  // of the detail: distance from the surface at which the outside is checked
constexpr double kFinest = 0.2;

double longestEdge(const Triangle& t) {
  return std::sqrt(
      std::max({(t[1] - t[0]).squaredNorm(), (t[2] - t[1]).squaredNorm(), (t[0] - t[2]).squaredNorm()}));
}

std::array<Triangle, 4> quarters(const Triangle& t) {
  const Vec3 ab = (t[0] + t[1]) / 2, bc = (t[1] + t[2]) / 2, ca = (t[2] + t[0]) / 2;
  return {{{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}}};
}

/// Sorts triangles into outer ones and others.
class Trimmer {
 public:
  Trimmer(const TriangleTree& tree, double detail_m) : tree_(tree), detail_m_(detail_m) {}

  bool isOuter(const Triangle& t, const Vec3& at) const {
    const double winding = tree_.windingNumber(at + kAbove * detail_m_ * normalOf(t));
    return std::abs(winding) < 0.5;
  }
  bool isOuter(const Triangle& t) const { return isOuter(t, (t[0] + t[1] + t[2]) / 3); }

  /// Appends the outer parts of a triangle that may be on both sides.
  void trim(const Triangle& t, std::vector<Triangle>& outer) const {
    if (longestEdge(t) < kFinest * detail_m_) {
      if (isOuter(t)) outer.push_back(t);
      return;
    }
    if (longestEdge(t) <= detail_m_) {
      const Vec3 middle = (t[0] + t[1] + t[2]) / 3;
      const bool first = isOuter(t, middle);
      bool same = true;
      for (const Vec3& corner : t) same = same && isOuter(t, corner + 0.02 * (middle - corner)) == first;
      if (same) {
        if (first) outer.push_back(t);
        return;
      }
    }
    for (const Triangle& quarter : quarters(t)) trim(quarter, outer);
  }

 private:
  const TriangleTree& tree_;
  double detail_m_;
};

/// The mesh with all edges at most `longest_m` long; shared edges are split alike.
TriangleMesh split(TriangleMesh mesh, double longest_m) {
  // Pieces share positions, not vertices: only their own triangle's vertex numbers identify neighbours below,
  // and pieces of a long triangle are always trimmed.
  TriangleMesh fine;
  fine.vertices = mesh.vertices;
  std::vector<Triangle> stack;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Triangle whole{mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]};
    if (longestEdge(whole) <= longest_m) {
      fine.triangles.push_back({a, b, c});
      continue;
    }
    stack.assign(1, whole);
    while (!stack.empty()) {
      const Triangle t = stack.back();
      stack.pop_back();
      if (longestEdge(t) > longest_m) {
        for (const Triangle& quarter : quarters(t)) stack.push_back(quarter);
        continue;
      }
      const int first = int(fine.vertices.size());
      fine.vertices.insert(fine.vertices.end(), t.begin(), t.end());
      fine.triangles.push_back({first, first + 1, first + 2});
    }
  }
  return fine;
}

}  // namespace

std::vector<Triangle> outerTriangles(const TriangleMesh& mesh, double detail_m) {
  const TriangleTree tree(cornersOf(mesh));
  const Trimmer trimmer(tree, detail_m);
  const TriangleMesh fine = split(mesh, detail_m);
  const std::vector<Triangle> triangles = cornersOf(fine);
  std::vector<char> outer(triangles.size());
  parallelFor(triangles.size(), 256, [&](std::size_t first, std::size_t last) {
    for (std::size_t t = first; t < last; ++t) outer[t] = trimmer.isOuter(triangles[t]);
  });
  // A triangle whose neighbours are on its side is on one side as a whole. Pieces have no neighbours.
  enum : char { kUnknown = 2, kMixed = 3 };
  std::vector<char> side(fine.vertices.size(), kUnknown);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (const int corner : fine.triangles[t])
      side[corner] = side[corner] == kUnknown || side[corner] == outer[t] ? outer[t] : char(kMixed);
  std::vector<std::vector<Triangle>> kept(triangles.size());
  parallelFor(triangles.size(), 256, [&](std::size_t first, std::size_t last) {
    for (std::size_t t = first; t < last; ++t) {
      const auto& corners = fine.triangles[t];
      const bool is_piece = std::size_t(corners[0]) >= mesh.vertices.size();
      const bool is_mixed =
          std::any_of(corners.begin(), corners.end(), [&](int c) { return side[c] == kMixed; });
      if (is_piece || is_mixed)
        trimmer.trim(triangles[t], kept[t]);
      else if (outer[t])
        kept[t].push_back(triangles[t]);
    }
  });
  std::vector<Triangle> all;
  for (const auto& some : kept) all.insert(all.end(), some.begin(), some.end());
  return all;
}

}  // namespace airclay
