// SPDX-License-Identifier: MIT
// Signed distances to a closed triangle mesh: the nearest point by a bounding volume hierarchy, the sign by
// the generalized winding number (Jacobson, Kavan and Sorkine-Hornung 2013, "Robust inside-outside
// segmentation using generalized winding numbers"), with distant triangles approximated as dipoles in the
// same hierarchy (Barill et al. 2018, "Fast winding numbers for soups and clouds").
#include "engine/mesh/distance_grid.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <thread>

#include "engine/core/error.h"

namespace airclay {
namespace {

constexpr double kMaxSamples = 256e6;  // 1 GB; more indicates a mistyped cell size

/// The point of a triangle nearest to `p` (Ericson 2004, "Real-Time Collision Detection", 5.1.5: by Voronoi
/// regions).
Vec3 nearestOnTriangle(const Vec3& p, const std::array<Vec3, 3>& t) {
  const Vec3 ab = t[1] - t[0], ac = t[2] - t[0];
  const Vec3 ap = p - t[0];
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return t[0];
  const Vec3 bp = p - t[1];
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return t[1];
  const double on_ab = d1 * d4 - d3 * d2;
  if (on_ab <= 0 && d1 >= 0 && d3 <= 0) return d1 == d3 ? t[0] : Vec3(t[0] + d1 / (d1 - d3) * ab);
  const Vec3 cp = p - t[2];
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return t[2];
  const double on_ac = d5 * d2 - d1 * d6;
  if (on_ac <= 0 && d2 >= 0 && d6 <= 0) return d2 == d6 ? t[0] : Vec3(t[0] + d2 / (d2 - d6) * ac);
  const double on_bc = d3 * d6 - d5 * d4;
  const double toward_c = d4 - d3, toward_b = d5 - d6;
  if (on_bc <= 0 && toward_c >= 0 && toward_b >= 0)
    return t[1] +
           toward_c / std::max(toward_c + toward_b, std::numeric_limits<double>::min()) * (t[2] - t[1]);
  const double sum = on_ab + on_ac + on_bc;
  return t[0] + on_ac / sum * ab + on_ab / sum * ac;
}

/// The solid angle of a triangle seen from `p`, positive on its inside (Van Oosterom and Strackee 1983).
double solidAngle(const Vec3& p, const std::array<Vec3, 3>& t) {
  const Vec3 a = t[0] - p, b = t[1] - p, c = t[2] - p;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  return 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
}

std::vector<std::array<Vec3, 3>> cornersOf(const TriangleMesh& mesh) {
  std::vector<std::array<Vec3, 3>> corners;
  corners.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles)
    corners.push_back({mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]});
  return corners;
}

/// A bounding volume hierarchy of axis-aligned boxes over triangles.
class Hierarchy {
 public:
  explicit Hierarchy(std::vector<std::array<Vec3, 3>> triangles) : triangles_(std::move(triangles)) {
    nodes_.reserve(2 * triangles_.size());
    build(0, int(triangles_.size()));
  }

  const Eigen::AlignedBox3d& box() const { return nodes_[0].box; }

  /// The distance to the nearest triangle, at most `bound`.
  double distance(const Vec3& point, double bound) const {
    double best = bound * bound;
    std::array<std::pair<int, double>, kMaxDepth> stack;
    size_t height = 0;
    stack[height++] = {0, nodes_[0].box.squaredExteriorDistance(point)};
    while (height > 0) {
      const auto [index, to_box] = stack[--height];
      if (to_box >= best) continue;
      const Node& node = nodes_[index];
      if (node.right == 0) {
        for (int i = node.first; i < node.first + node.count; ++i)
          best = std::min(best, (point - nearestOnTriangle(point, triangles_[i])).squaredNorm());
        continue;
      }
      std::pair<int, double> near{index + 1, nodes_[index + 1].box.squaredExteriorDistance(point)};
      std::pair<int, double> far{node.right, nodes_[node.right].box.squaredExteriorDistance(point)};
      if (far.second < near.second) std::swap(near, far);
      stack[height++] = far;
      stack[height++] = near;
    }
    return std::sqrt(best);
  }

  /// 1 inside, 0 outside; other values where the mesh intersects itself.
  double windingNumber(const Vec3& point, int index = 0) const {
    const Node& node = nodes_[index];
    const Vec3 offset = node.center - point;
    const double distance = offset.norm();
    if (distance > kFarRadii * node.radius)
      return node.area_vector.dot(offset) / (4 * std::numbers::pi * distance * distance * distance);
    if (node.right != 0) return windingNumber(point, index + 1) + windingNumber(point, node.right);
    double sum = 0;
    for (int i = node.first; i < node.first + node.count; ++i) sum += solidAngle(point, triangles_[i]);
    return sum / (4 * std::numbers::pi);
  }

 private:
  static constexpr int kLeaf = 8;
  static constexpr size_t kMaxDepth = 64;  // each level halves the count
  // At 3 radii, the dipole approximation has an error of a few hundredths. Only comparison with 1/2 matters.
  static constexpr double kFarRadii = 3;

  struct Node {
    Eigen::AlignedBox3d box;
    Vec3 center = Vec3::Zero();       // of the triangles, weighted by area
    Vec3 area_vector = Vec3::Zero();  // the sum of their normals times areas
    double radius = 0;                // distance from `center` to the farthest corner
    int first = 0, count = 0;         // in triangles_
    int right = 0;                    // second child (the first follows its parent); 0: a leaf
  };

  int build(int first, int count) {
    const int index = int(nodes_.size());
    nodes_.emplace_back();
    Node node;
    node.first = first, node.count = count;
    double area = 0;
    Eigen::AlignedBox3d centroids;
    for (int i = first; i < first + count; ++i) {
      const auto& [a, b, c] = triangles_[i];
      const Vec3 normal = (b - a).cross(c - a) / 2;
      const double weight = normal.norm() + std::numeric_limits<double>::min();
      node.area_vector += normal;
      node.center += weight * (a + b + c) / 3;
      area += weight;
      centroids.extend((a + b + c) / 3);
      for (const Vec3& corner : triangles_[i]) node.box.extend(corner);
    }
    node.center /= area;
    for (int i = first; i < first + count; ++i)
      for (const Vec3& corner : triangles_[i])
        node.radius = std::max(node.radius, (corner - node.center).norm());
    if (count > kLeaf) {
      int axis = 0;
      centroids.sizes().maxCoeff(&axis);
      const auto position = [axis](const std::array<Vec3, 3>& t) {
        return t[0][axis] + t[1][axis] + t[2][axis];
      };
      const auto begin = triangles_.begin() + first;
      std::nth_element(begin, begin + count / 2, begin + count,
                       [&](const auto& a, const auto& b) { return position(a) < position(b); });
      build(first, count / 2);
      node.right = build(first + count / 2, count - count / 2);
    }
    nodes_[index] = node;
    return index;
  }

  std::vector<std::array<Vec3, 3>> triangles_;
  std::vector<Node> nodes_;
};

/// Fills one row of samples along x. Between samples the distance changes at most by their spacing, which
/// bounds the search; if both are farther from the surface than that, they are on the same side.
void fillRow(const Hierarchy& hierarchy, DistanceGrid& grid, int j, int k) {
  const double largest = std::numeric_limits<double>::max();
  double distance = std::sqrt(largest), sign = 0;
  for (int i = 0; i < grid.size[0]; ++i) {
    const Vec3 point = grid.low_corner + grid.cell_m * Vec3(i, j, k);
    const double before = distance;
    const double bound = i == 0 ? std::sqrt(largest) : before + 1.001 * grid.cell_m;
    distance = hierarchy.distance(point, bound);
    if (sign == 0 || before + distance <= 1.001 * grid.cell_m)
      sign = hierarchy.windingNumber(point) > 0.5 ? -1 : 1;
    grid.values[size_t(i) + size_t(grid.size[0]) * (size_t(j) + size_t(grid.size[1]) * k)] =
        float(sign * distance);
  }
}

}  // namespace

DistanceGrid signedDistanceGrid(const TriangleMesh& mesh, double cell_m, double margin_m) {
  const TriangleMesh closed = withCaps(mesh);
  if (closed.triangles.empty())
    throw Error("distance grid: the mesh has no triangles; expected the surface of a solid");
  const Hierarchy hierarchy(cornersOf(closed));
  DistanceGrid grid;
  grid.cell_m = cell_m;
  const Vec3 extent = hierarchy.box().sizes() + Vec3::Constant(2 * margin_m);
  const Vec3 cells = (extent / cell_m).array().ceil();
  const double samples = (cells + Vec3::Ones()).prod();
  if (!(cell_m > 0 && margin_m >= 0 && samples <= kMaxSamples))
    throw Error("distance grid: cells of " + std::to_string(cell_m) + " m around a mesh of " +
                std::to_string(extent.maxCoeff()) + " m; expected at most 256 million samples");
  for (int axis = 0; axis < 3; ++axis) grid.size[axis] = int(cells[axis]) + 1;
  grid.low_corner = hierarchy.box().center() - cells * cell_m / 2;
  grid.values.resize(size_t(samples));

  std::atomic<int> next_slab{0};
  const auto fill_slabs = [&] {
    for (int k = next_slab++; k < grid.size[2]; k = next_slab++)
      for (int j = 0; j < grid.size[1]; ++j) fillRow(hierarchy, grid, j, k);
  };
  std::vector<std::thread> threads;
  for (unsigned t = 1; t < std::thread::hardware_concurrency(); ++t) threads.emplace_back(fill_slabs);
  fill_slabs();
  for (std::thread& thread : threads) thread.join();
  return grid;
}

double sample(const DistanceGrid& grid, const Vec3& point) {
  const Vec3 last(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1);
  const Vec3 in_cells = (point - grid.low_corner) / grid.cell_m;
  const Vec3 clamped = in_cells.cwiseMax(Vec3::Zero()).cwiseMin(last);
  std::array<size_t, 3> low{};
  Vec3 fraction;
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = size_t(std::clamp(std::floor(clamped[axis]), 0., std::max(last[axis] - 1, 0.)));
    fraction[axis] = clamped[axis] - double(low[axis]);
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    std::array<size_t, 3> at = low;
    for (int axis = 0; axis < 3; ++axis) {
      const bool high = (corner >> axis) & 1;
      weight *= high ? fraction[axis] : 1 - fraction[axis];
      at[axis] += high;
    }
    if (weight > 0)
      sum += weight * grid.values[at[0] + size_t(grid.size[0]) * (at[1] + size_t(grid.size[1]) * at[2])];
  }
  return sum + (in_cells - clamped).norm() * grid.cell_m;
}

double signedDistance(const TriangleMesh& mesh, const Vec3& point) {
  double nearest = std::numeric_limits<double>::infinity(), winding = 0;
  for (const auto& triangle : cornersOf(withCaps(mesh))) {
    nearest = std::min(nearest, (point - nearestOnTriangle(point, triangle)).norm());
    winding += solidAngle(point, triangle) / (4 * std::numbers::pi);
  }
  return winding > 0.5 ? -nearest : nearest;
}

}  // namespace airclay
