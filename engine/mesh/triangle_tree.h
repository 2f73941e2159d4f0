// SPDX-License-Identifier: MIT
// A bounding volume hierarchy over triangles: the nearest point, and the generalized winding number.
#pragma once

#include <limits>

#include "engine/mesh/mesh.h"

namespace airclay {

using Triangle = std::array<Vec3, 3>;  ///< corners, counterclockwise seen from outside

/// The corners of each triangle.
std::vector<Triangle> cornersOf(const TriangleMesh& mesh);

/// The point of a triangle nearest to `point` (Ericson 2004, "Real-Time Collision Detection", 5.1.5: by
/// Voronoi regions).
Vec3 nearestOnTriangle(const Vec3& point, const Triangle& triangle);

/// The solid angle of a triangle seen from `point`, positive on its inside (Van Oosterom and Strackee 1983).
double solidAngle(const Vec3& point, const Triangle& triangle);

/// The triangle's unit normal, outwards; zero if it has no area.
Vec3 normalOf(const Triangle& triangle);

/// A hierarchy of axis-aligned boxes. Its functions may be called from several threads.
class TriangleTree {
 public:
  /// \pre at least one triangle
  explicit TriangleTree(std::vector<Triangle> triangles);

  const Eigen::AlignedBox3d& box() const { return nodes_[0].box; }
  const Triangle& triangle(int index) const { return triangles_[static_cast<std::size_t>(index)]; }

  /// The index in the constructor's list; triangle() has another order.
  int originalIndex(int index) const { return order_[static_cast<std::size_t>(index)]; }

  /// The distance to the nearest triangle, at most `bound`.
  double distance(const Vec3& point, double bound) const;

  struct Hit {
    Vec3 point = Vec3::Zero();
    int triangle = -1;  ///< for triangle(); -1: none within reach
    double distance = 0;
  };
  /// The nearest point within `reach`.
  Hit nearest(const Vec3& point, double reach = std::numeric_limits<double>::infinity()) const;
  /// The nearest point of the triangles whose normal is at most 90 degrees from `direction`.
  Hit nearestFacing(const Vec3& point, double reach, const Vec3& direction) const;

  /// 1 inside, 0 outside; other values where the mesh intersects itself (Jacobson, Kavan and Sorkine-Hornung
  /// 2013, "Robust inside-outside segmentation using generalized winding numbers"). Distant triangles count
  /// as dipoles (Barill et al. 2018, "Fast winding numbers for soups and clouds"): within a few hundredths.
  double windingNumber(const Vec3& point) const { return windingNumber(point, 0); }

 private:
  static constexpr int kLeaf = 8;
  static constexpr std::size_t kMaxDepth = 64;  // each level halves the count
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

  int build(int first, int count);
  double windingNumber(const Vec3& point, int index) const;
  template <typename Visit>
  void visitNear(const Vec3& point, double& squared_reach, const Visit& visit) const;

  std::vector<int> order_;
  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

}  // namespace airclay
