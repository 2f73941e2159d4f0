// SPDX-License-Identifier: MIT
// Splits polygons into triangles: quads along the shorter diagonal, larger ones by ear clipping (Meisters
// 1975, "Polygons have ears", Amer. Math. Monthly 82(6): a simple polygon of at least four corners has two
// ears).
#include <algorithm>
#include <limits>

#include "engine/core/error.h"
#include "engine/core/task.h"
#include "engine/mesh/mesh_export.h"

namespace airclay {
namespace {

using Triangles = std::vector<std::array<int, 3>>;

// Ear clipping takes quadratic time: seconds at ten times as many.
constexpr std::size_t kMaxCorners = 10'000;
// Relative to the polygon's area. Less counts as zero, as rounding leaves at a straight corner.
constexpr double kFlat = 1e-12;
constexpr double kNoEar = std::numeric_limits<double>::infinity();

/// Twice the signed area of a triangle, positive if counterclockwise.
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
  // In a concave quad, or with a straight corner, one diagonal is outside or along an edge.
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

/// Clips the ears of one polygon.
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
        measureAll();  // clipping may have removed a corner that blocked another ear
        ear = shortest();
      }
      clip(ear, triangles);
    }
    triangles.push_back({corners_[0], corners_[1], corners_[2]});
  }

 private:
  std::size_t before(std::size_t i) const { return (i + corners_.size() - 1) % corners_.size(); }
  std::size_t after(std::size_t i) const { return (i + 1) % corners_.size(); }

  /// The ear with the shortest diagonal; any corner if the polygon intersects itself or has no area.
  std::size_t shortest() const {
    return std::size_t(std::min_element(diagonals_.begin(), diagonals_.end()) - diagonals_.begin());
  }

  void measureAll() {
    for (std::size_t i = 0; i < corners_.size(); ++i) measure(i);
  }

  /// Computes the squared length of the diagonal that cuts off corner i; kNoEar if it is not an ear.
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
  std::vector<double> diagonals_;  ///< squared lengths; kNoEar for corners that are not ears
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
                  " corners; expected 3 to " + std::to_string(kMaxCorners));
    if (face.size() == 3) triangles.push_back({face[0], face[1], face[2]});
    if (face.size() == 4) splitQuad(mesh.points, face, triangles);
    if (face.size() > 4) EarClipper(mesh.points, face).split(triangles);
  }
  return triangles;
}

}  // namespace airclay
