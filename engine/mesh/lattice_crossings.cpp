// SPDX-License-Identifier: MIT
// Rasterizes each triangle onto the lattice lines with exact integer edge functions. Wang 2011, "Approximate
// Boolean operations on large polyhedral solids with partial mesh reconstruction", represents solids by such
// samples, layered depth-normal images.
#include "engine/mesh/lattice_crossings.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "engine/core/task.h"

namespace airclay {
namespace {

// Vertices are even and lattice points odd multiples of 2^-17 spacings. The largest product of two
// differences, (4096 * 2^17)^2 = 2^58, fits into 64 bits.
constexpr int kHalfBits = 16;
constexpr std::int64_t kSpacing = std::int64_t(1) << (kHalfBits + 1);

struct IntegerPoint {
  std::int64_t u, v;
};

std::int64_t rounded(double spacings) {
  return 2 * std::llround(std::ldexp(spacings, kHalfBits));
}

std::int64_t ofLatticePoint(int index) {
  return index * kSpacing + 1;
}

/// The first lattice point at or after the coordinate, and the last one at or before it.
int firstFrom(std::int64_t at) {
  return int((at - 1 + kSpacing - 1) >> (kHalfBits + 1));
}
int lastUpTo(std::int64_t at) {
  return int((at - 1) >> (kHalfBits + 1));
}

/// Twice the signed area of a, b, p.
std::int64_t area(const IntegerPoint& a, const IntegerPoint& b, const IntegerPoint& p) {
  return (b.u - a.u) * (p.v - a.v) - (b.v - a.v) * (p.u - a.u);
}

/// Whether a point is left of the edge, with which it spans twice_area. On the edge, the answer depends only
/// on the two ends, not on their order: both triangles at the edge agree.
bool isLeft(const IntegerPoint& a, const IntegerPoint& b, std::int64_t twice_area) {
  if (twice_area != 0) return twice_area > 0;
  return a.u != b.u ? a.u < b.u : a.v < b.v;
}

/// Disjoint sets (Tarjan's union-find, with path halving); the smaller index becomes the root.
class Sets {
 public:
  explicit Sets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  int find(int member) {
    while (parent_[std::size_t(member)] != member)
      member = parent_[std::size_t(member)] = parent_[std::size_t(parent_[std::size_t(member)])];
    return member;
  }
  void join(int a, int b) {
    const auto [root, child] = std::minmax({find(a), find(b)});
    parent_[std::size_t(child)] = root;
  }

 private:
  std::vector<int> parent_;
};

}  // namespace

Lattice latticeAround(const Eigen::AlignedBox3d& box, double spacing_m) {
  Lattice lattice;
  lattice.spacing_m = spacing_m;
  for (int axis = 0; axis < 3; ++axis)
    lattice.size[axis] = int(std::min(std::ceil(box.sizes()[axis] / spacing_m) + 5, 1e9));
  lattice.low_corner =
      box.center() - spacing_m / 2 * Vec3(lattice.size[0] - 1, lattice.size[1] - 1, lattice.size[2] - 1);
  return lattice;
}

LatticeCrossings::LatticeCrossings(const TriangleMesh& mesh, const Lattice& lattice, int axis)
    : lattice_(lattice), axis_(axis) {
  const int u_axis = (axis + 1) % 3, v_axis = (axis + 2) % 3;
  const std::size_t u_size = std::size_t(lattice.size[u_axis]);
  std::vector<IntegerPoint> flat;
  std::vector<double> depths;
  for (const Vec3& vertex : mesh.vertices) {
    const Vec3 at = (vertex - lattice.low_corner) / lattice.spacing_m;
    flat.push_back({rounded(at[u_axis]), rounded(at[v_axis])});
    depths.push_back(at[axis]);
  }
  std::vector<std::pair<std::size_t, Crossing>> found;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    reportProgress(t, mesh.triangles.size());
    const auto& [i, j, k] = mesh.triangles[t];
    const IntegerPoint &a = flat[i], &b = flat[j], &c = flat[k];
    const std::int64_t orientation = area(a, b, c);
    if (orientation == 0) continue;
    for (int v = firstFrom(std::min({a.v, b.v, c.v})); v <= lastUpTo(std::max({a.v, b.v, c.v})); ++v)
      for (int u = firstFrom(std::min({a.u, b.u, c.u})); u <= lastUpTo(std::max({a.u, b.u, c.u})); ++u) {
        const IntegerPoint p{ofLatticePoint(u), ofLatticePoint(v)};
        const std::int64_t of_c = area(a, b, p), of_a = area(b, c, p), of_b = area(c, a, p);
        const bool left = isLeft(a, b, of_c);
        if (left != isLeft(b, c, of_a) || left != isLeft(c, a, of_b)) continue;
        const double depth =
            (double(of_a) * depths[i] + double(of_b) * depths[j] + double(of_c) * depths[k]) /
            double(orientation);
        // Counterclockwise seen from the line's far end: the line leaves the solid.
        found.push_back({std::size_t(u) + u_size * std::size_t(v), {depth, int(t), left ? -1 : 1}});
      }
  }
  starts_.assign(u_size * std::size_t(lattice.size[v_axis]) + 1, 0);
  for (const auto& [line, crossing] : found) ++starts_[line + 1];
  std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
  crossings_.resize(found.size());
  std::vector<std::size_t> next(starts_.begin(), starts_.end() - 1);
  for (const auto& [line, crossing] : found) crossings_[next[line]++] = crossing;
  // Entering before leaving: solids that touch have no gap.
  const auto before = [](const Crossing& a, const Crossing& b) {
    if (a.position != b.position) return a.position < b.position;
    return a.step != b.step ? a.step > b.step : a.triangle < b.triangle;
  };
  for (std::size_t line = 0; line + 1 < starts_.size(); ++line)
    std::sort(crossings_.begin() + std::ptrdiff_t(starts_[line]),
              crossings_.begin() + std::ptrdiff_t(starts_[line + 1]), before);
}

SolidStructure solidStructure(const TriangleMesh& mesh, const Lattice& lattice) {
  constexpr int kAxis = 2;
  constexpr double kShortest = 1e-3;  // of a spacing; shorter overlaps are solids that touch
  Sets parts(mesh.vertices.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    parts.join(a, b);
    parts.join(b, c);
  }
  std::vector<int> part_of_triangle;
  for (const auto& triangle : mesh.triangles) part_of_triangle.push_back(parts.find(triangle[0]));

  SolidStructure structure;
  Sets groups(mesh.vertices.size());
  std::vector<int> overlapping;  // parts
  const LatticeCrossings crossings(mesh, lattice, kAxis);
  std::vector<std::pair<int, int>> windings;  // of the parts around the current place of the line
  double length = 0;                          // inside, in spacings
  for (std::size_t line = 0; line < crossings.lineCount(); ++line) {
    windings.clear();
    int winding = 0;
    double from = 0;
    for (const Crossing& crossing : crossings.line(line)) {
      if (winding > 0) length += crossing.position - from;
      if (crossing.position - from > kShortest) {
        for (std::size_t i = 1; i < windings.size(); ++i) groups.join(windings[0].first, windings[i].first);
        if (winding != 0 && winding != 1) overlapping.push_back(windings[0].first);
      }
      const int part = part_of_triangle[std::size_t(crossing.triangle)];
      auto at = std::find_if(windings.begin(), windings.end(),
                             [&](const auto& entry) { return entry.first == part; });
      if (at == windings.end()) at = windings.insert(at, {part, 0});
      at->second += crossing.step;
      if (at->second == 0) windings.erase(at);
      winding += crossing.step;
      from = crossing.position;
    }
  }
  structure.volume_m3 = length * std::pow(lattice.spacing_m, 3);

  std::vector<int> group_of_root(mesh.vertices.size(), -1);
  for (const int part : part_of_triangle) {
    int& group = group_of_root[std::size_t(groups.find(part))];
    if (group < 0) group = structure.groups++;
    structure.group_of_triangle.push_back(group);
  }
  structure.overlaps.assign(std::size_t(structure.groups), false);
  for (const int part : overlapping)
    structure.overlaps[std::size_t(group_of_root[std::size_t(groups.find(part))])] = true;
  return structure;
}

std::size_t openEdges(const TriangleMesh& mesh) {
  std::vector<std::pair<int, int>> forward, backward;
  for (const auto& triangle : mesh.triangles)
    for (int i = 0; i < 3; ++i) {
      const int a = triangle[i], b = triangle[(i + 1) % 3];
      if (a < b) forward.emplace_back(a, b);
      if (b < a) backward.emplace_back(b, a);
    }
  std::sort(forward.begin(), forward.end());
  std::sort(backward.begin(), backward.end());
  std::vector<std::pair<int, int>> unmatched;
  std::set_symmetric_difference(forward.begin(), forward.end(), backward.begin(), backward.end(),
                                std::back_inserter(unmatched));
  return unmatched.size();
}

}  // namespace airclay
