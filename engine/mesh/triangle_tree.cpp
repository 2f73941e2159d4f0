// SPDX-License-Identifier: MIT
#include "engine/mesh/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace airclay {

Vec3 nearestOnTriangle(const Vec3& p, const Triangle& t) {
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

double solidAngle(const Vec3& p, const Triangle& t) {
  const Vec3 a = t[0] - p, b = t[1] - p, c = t[2] - p;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  return 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
}

Vec3 normalOf(const Triangle& t) {
  return (t[1] - t[0]).cross(t[2] - t[0]).normalized();  // Eigen does not change a zero vector
}

std::vector<Triangle> cornersOf(const TriangleMesh& mesh) {
  std::vector<Triangle> corners;
  corners.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles)
    corners.push_back({mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]});
  return corners;
}

TriangleTree::TriangleTree(std::vector<Triangle> triangles)
    : order_(triangles.size()), triangles_(std::move(triangles)) {
  std::iota(order_.begin(), order_.end(), 0);
  nodes_.reserve(2 * triangles_.size());
  build(0, int(triangles_.size()));
  std::vector<Triangle> sorted;
  sorted.reserve(triangles_.size());
  for (const int index : order_) sorted.push_back(triangles_[index]);
  triangles_ = std::move(sorted);
}

/// Calls visit(triangle) for the triangles of each leaf whose box is within reach, nearer boxes first.
/// `visit` may reduce the reach.
template <typename Visit>
void TriangleTree::visitNear(const Vec3& point, double& squared_reach, const Visit& visit) const {
  std::array<std::pair<int, double>, kMaxDepth> stack;
  std::size_t height = 0;
  stack[height++] = {0, nodes_[0].box.squaredExteriorDistance(point)};
  while (height > 0) {
    const auto [index, to_box] = stack[--height];
    if (to_box >= squared_reach) continue;
    const Node& node = nodes_[index];
    if (node.right == 0) {
      for (int i = node.first; i < node.first + node.count; ++i) visit(i);
      continue;
    }
    std::pair<int, double> near{index + 1, nodes_[index + 1].box.squaredExteriorDistance(point)};
    std::pair<int, double> far{node.right, nodes_[node.right].box.squaredExteriorDistance(point)};
    if (far.second < near.second) std::swap(near, far);
    stack[height++] = far;
    stack[height++] = near;
  }
}

double TriangleTree::distance(const Vec3& point, double bound) const {
  double best = bound * bound;
  visitNear(point, best, [&](int i) {
    best = std::min(best, (point - nearestOnTriangle(point, triangles_[i])).squaredNorm());
  });
  return std::sqrt(best);
}

TriangleTree::Hit TriangleTree::nearest(const Vec3& point, double reach) const {
  Hit hit;
  double best = reach * reach;
  visitNear(point, best, [&](int i) {
    const Vec3 candidate = nearestOnTriangle(point, triangles_[i]);
    const double squared = (point - candidate).squaredNorm();
    if (squared >= best) return;
    best = squared;
    hit = {candidate, i, 0};
  });
  hit.distance = std::sqrt(best);
  return hit;
}

TriangleTree::Hit TriangleTree::nearestFacing(const Vec3& point, double reach, const Vec3& direction) const {
  Hit hit;
  double best = reach * reach;
  visitNear(point, best, [&](int i) {
    const Triangle& t = triangles_[i];
    const Vec3 candidate = nearestOnTriangle(point, t);
    const double squared = (point - candidate).squaredNorm();
    if (squared >= best || (t[1] - t[0]).cross(t[2] - t[0]).dot(direction) < 0) return;
    best = squared;
    hit = {candidate, i, 0};
  });
  hit.distance = std::sqrt(best);
  return hit;
}

double TriangleTree::windingNumber(const Vec3& point, int index) const {
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

int TriangleTree::build(int first, int count) {
  const int index = int(nodes_.size());
  nodes_.emplace_back();
  Node node;
  node.first = first, node.count = count;
  double area = 0;
  Eigen::AlignedBox3d centroids;
  for (int i = first; i < first + count; ++i) {
    const auto& [a, b, c] = triangles_[order_[i]];
    const Vec3 normal = (b - a).cross(c - a) / 2;
    const double weight = normal.norm() + std::numeric_limits<double>::min();
    node.area_vector += normal;
    node.center += weight * (a + b + c) / 3;
    area += weight;
    centroids.extend((a + b + c) / 3);
    for (const Vec3& corner : triangles_[order_[i]]) node.box.extend(corner);
  }
  node.center /= area;
  for (int i = first; i < first + count; ++i)
    for (const Vec3& corner : triangles_[order_[i]])
      node.radius = std::max(node.radius, (corner - node.center).squaredNorm());
  node.radius = std::sqrt(node.radius);
  if (count > kLeaf) {
    int axis = 0;
    centroids.sizes().maxCoeff(&axis);
    const auto position = [&](int i) {
      const Triangle& t = triangles_[i];
      return t[0][axis] + t[1][axis] + t[2][axis];
    };
    const auto begin = order_.begin() + first;
    std::nth_element(begin, begin + count / 2, begin + count,
                     [&](int a, int b) { return position(a) < position(b); });
    build(first, count / 2);
    node.right = build(first + count / 2, count - count / 2);
  }
  nodes_[index] = node;
  return index;
}

}  // namespace airclay
