// SPDX-License-Identifier: MIT
// Polygons into triangles: quads along the shorter diagonal, larger ones by clipping ears (Meisters 1975,
// "Polygons have ears", Amer. Math. Monthly 82(6): a simple polygon of four corners or more has two).
#include <algorithm>
#include <limits>

#include "engine/core/error.h"
#include "engine/core/task.h"
#include "engine/mesh/mesh_export.h"

namespace airclay {
namespace {

using Triangles = std::vector<std::array<int, 3>>;

// Clipping takes time with the square of this, and seconds at ten times as many.
constexpr std::size_t kMaxCorners = 10'000;
// Of the polygon's area: less is flat, and what rounding makes of a straight corner.
constexpr double kFlat = 1e-12;
constexpr double kNoEar = std::numeric_limits<double>::infinity();

/// Twice the area of a triangle, positive when it runs anticlockwise.
double twiceArea(const Vec2& a, const Vec2& b, const Vec2& c) {
  const Vec2 u = b - a, v = c - a;
  return u.x() * v.y() - u.y() * v.x();
}

void splitQuad(const std::vector<Vec3>& points, const std::vector<int>& quad, Triangles& triangles) {
  const auto& [a, b, c, d] = std::array{quad[0], quad[1], quad[2], quad[3]};
  const Vec3 ac = points[c] - points[a], bd = points[d] - points[b];
  const Vec3 normal = ac.cross(bd);
  const auto faces = [&](int i, int j, int k) {
    return normal.dot((points[j] - points[i]).cross(points[k] - points[i])) > kFlat * normal.squaredNorm();
  };
  // In an arrowhead, or with a straight corner, one diagonal runs outside or along an edge.
  const bool ac_inside = faces(a, b, c) && faces(a, c, d), bd_inside = faces(a, b, d) && faces(b, c, d);
  const bool bd_shorter = bd.squaredNorm() < ac.squaredNorm();
  if (ac_inside == bd_inside ? bd_shorter : bd_inside) {
    triangles.push_back({a, b, d});
    triangles.push_back({b, c, d});
  } else {
    triangles.push_back({a, b, c});
    triangles.push_back({a, c, d});
  }
}

/// A polygon that loses ear after ear.
class EarClipper {
 public:
  EarClipper(const std::vector<Vec3>& points, const std::vector<int>& face) : corners_(face) {
    Vec3 normal = Vec3::Zero();
    for (std::size_t i = 2; i < face.size(); ++i)
      normal += (points[face[i - 1]] - points[face[0]]).cross(points[face[i]] - points[face[0]]);
    flat_area_ = kFlat * normal.norm();
    const Vec3 x = normal.unitOrthogonal(), y = normal.cross(x).normalized();
    for (const int corner : face) {
      const Vec3 from_first = points[corner] - points[face[0]];
      flat_.emplace_back(x.dot(from_first), y.dot(from_first));
    }
    diagonals_.resize(face.size());
  }

  void split(Triangles& triangles) {
    measureAll();
    while (corners_.size() > 3) {
      std::size_t ear = shortest();
      if (diagonals_[ear] == kNoEar) {
        measureAll();  // a corner clipped since may have stood in the way of an ear farther off
        ear = shortest();
      }
      clip(ear, triangles);
    }
    triangles.push_back({corners_[0], corners_[1], corners_[2]});
  }

 private:
  std::size_t before(std::size_t i) const { return (i + corners_.size() - 1) % corners_.size(); }
  std::size_t after(std::size_t i) const { return (i + 1) % corners_.size(); }

  /// Of a polygon that crosses itself, or without area, any corner.
  std::size_t shortest() const {
    return std::size_t(std::min_element(diagonals_.begin(), diagonals_.end()) - diagonals_.begin());
  }

  void measureAll() {
    for (std::size_t i = 0; i < corners_.size(); ++i) measure(i);
  }

  /// The squared length of the diagonal that cuts off corner i, where that is an ear.
  void measure(std::size_t i) {
    const Vec2 &a = flat_[before(i)], &b = flat_[i], &c = flat_[after(i)];
    diagonals_[i] = kNoEar;
    if (twiceArea(a, b, c) <= flat_area_) return;
    for (const Vec2& point : flat_)
      if (point != a && point != b && point != c && twiceArea(a, b, point) >= -flat_area_ &&
          twiceArea(b, c, point) >= -flat_area_ && twiceArea(c, a, point) >= -flat_area_)
        return;
    diagonals_[i] = (c - a).squaredNorm();
  }

  void clip(std::size_t ear, Triangles& triangles) {
    triangles.push_back({corners_[before(ear)], corners_[ear], corners_[after(ear)]});
    const auto place = std::ptrdiff_t(ear);
    corners_.erase(corners_.begin() + place);
    flat_.erase(flat_.begin() + place);
    diagonals_.erase(diagonals_.begin() + place);
    measure(before(ear));
    measure(ear % corners_.size());
  }

  double flat_area_ = 0;
  std::vector<int> corners_;
  std::vector<Vec2> flat_;         ///< the corners in the polygon's plane
  std::vector<double> diagonals_;  ///< squared lengths; kNoEar where the corner is none
};

}  // namespace

std::vector<std::array<int, 3>> triangulated(const PolygonMesh& mesh) {
  Triangles triangles;
  triangles.reserve(2 * mesh.faces.size());
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    reportProgress(i, mesh.faces.size());
    const std::vector<int>& face = mesh.faces[i];
    if (face.size() < 3 || face.size() > kMaxCorners)
      throw Error("face " + std::to_string(i + 1) + " has " + std::to_string(face.size()) +
                  " corners; 3 to " + std::to_string(kMaxCorners) + " can be split into triangles");
    if (face.size() == 3) triangles.push_back({face[0], face[1], face[2]});
    if (face.size() == 4) splitQuad(mesh.points, face, triangles);
    if (face.size() > 4) EarClipper(mesh.points, face).split(triangles);
  }
  return triangles;
}

}  // namespace airclay
