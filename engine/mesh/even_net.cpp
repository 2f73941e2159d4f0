// SPDX-License-Identifier: MIT
#include "engine/mesh/even_net.h"

#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"

namespace airclay {
namespace {

constexpr int kRounds = 8, kCreasedRounds = 4;  // more barely improve the quads
constexpr int kUntanglingRounds = 3;            // of kRounds
constexpr double kTowards = 0.7;                // of the way to the mean
constexpr double kReach = 2;                    // spacings; farther surface belongs to something else
// A quad across a crease has a corner within half an edge of it.
constexpr double kSnap = 0.5, kCornerSnap = 0.8;
constexpr double kApart = 0.5;        // edges between points that move to a crease
constexpr double kFlatCosine = 0.85;  // quads that differ by less have no crease between them
constexpr std::size_t kGrain = 128;

/// The net's connectivity around each point.
struct Neighbourhood {
  std::vector<std::vector<int>> quads;  ///< of each point
  std::vector<std::vector<int>> along;  ///< neighbours of a point on a crease, on creases or corners
};

Neighbourhood neighbourhoodOf(const QuadNet& net) {
  Neighbourhood around{std::vector<std::vector<int>>(net.points.size()),
                       std::vector<std::vector<int>>(net.points.size())};
  for (std::size_t q = 0; q < net.quads.size(); ++q)
    for (int k = 0; k < 4; ++k) {
      const int from = net.quads[q][k], to = net.quads[q][(k + 1) % 4];
      around.quads[from].push_back(int(q));
      if (net.features[from] == Feature::kCrease && net.features[to] != Feature::kSmooth)
        around.along[from].push_back(to);  // every edge occurs once in each direction
    }
  return around;
}

/// One round's view of the net; each point's new position depends only on the old ones.
class Round {
 public:
  Round(const QuadNet& net, const Neighbourhood& around, const TriangleTree& surface, double spacing_m,
        bool untangles = false)
      : net_(net), around_(around), surface_(surface), spacing_m_(spacing_m), untangles_(untangles) {
    for (const auto& quad : net.quads) {
      areas_.push_back(areaVector(net, quad));
      centroids_.push_back(
          (net.points[quad[0]] + net.points[quad[1]] + net.points[quad[2]] + net.points[quad[3]]) / 4);
    }
  }

  /// The place on a crease or corner where the surfaces around the point meet; kSmooth if there is none
  /// nearby.
  Vec3 snapped(std::size_t v, Feature& feature) const {
    const Vec3& at = net_.points[v];
    feature = Feature::kSmooth;
    double least = 1;
    for (const int a : around_.quads[v])
      for (const int b : around_.quads[v])
        least = std::min(least, areas_[a].dot(areas_[b]) / (areas_[a].norm() * areas_[b].norm() + 1e-300));
    if (least > kFlatCosine) return at;
    std::vector<TangentPlane> planes;
    for (const int quad : around_.quads[v]) {
      addPlane(centroids_[quad], areas_[quad], planes);
      for (const int corner : net_.quads[quad])
        if (corner != int(v)) addPlane((net_.points[corner] + at) / 2, areas_[quad], planes);
    }
    const Vec3 meeting = meetingPoint(planes, at, feature);
    const double reach = feature == Feature::kCorner ? kCornerSnap : kSnap;
    if ((meeting - at).norm() > reach * spacing_m_) feature = Feature::kSmooth;
    return feature == Feature::kSmooth ? at : meeting;
  }

  Vec3 moved(std::size_t v) const {
    const Vec3& at = net_.points[v];
    if (net_.features[v] == Feature::kCorner) return at;
    if (net_.features[v] == Feature::kCrease) return alongCrease(v);
    Vec3 normal = Vec3::Zero(), mean = Vec3::Zero();
    double weights = 0;
    for (const int quad : around_.quads[v]) {
      const double weight = areas_[quad].norm();
      normal += areas_[quad];
      mean += weight * centroids_[quad];
      weights += weight;
    }
    if (!(weights > 0)) return at;
    Vec3 step = mean / weights - at;
    if (normal.squaredNorm() > 0) {
      normal.normalize();
      if (!untangles_) step -= normal * normal.dot(step);
    }
    const Vec3 target = at + kTowards * step;
    const TriangleTree::Hit hit = surface_.nearestFacing(target, kReach * spacing_m_, normal);
    return hit.triangle >= 0 ? hit.point : at;
  }

 private:
  void addPlane(const Vec3& point, const Vec3& direction, std::vector<TangentPlane>& planes) const {
    const TriangleTree::Hit hit = surface_.nearestFacing(point, kReach * spacing_m_, direction);
    if (hit.triangle >= 0) planes.push_back({hit.point, normalOf(surface_.triangle(hit.triangle))});
  }

  Vec3 alongCrease(std::size_t v) const {
    const Vec3& at = net_.points[v];
    const std::vector<int>& ends = around_.along[v];
    Vec3 start = at;
    if (ends.size() == 2) {
      const Vec3 &a = net_.points[ends[0]], &b = net_.points[ends[1]];
      const Vec3 direction = (b - a).normalized();
      start += kTowards * direction * direction.dot((a + b) / 2 - at);
    }
    // The crease is where the surfaces under the quads on its two sides meet.
    std::vector<TangentPlane> planes;
    for (const int quad : around_.quads[v]) addPlane((centroids_[quad] + start) / 2, areas_[quad], planes);
    Feature feature = Feature::kSmooth;
    const Vec3 meeting = meetingPoint(planes, start, feature);
    if (feature == Feature::kCrease && (meeting - start).norm() < spacing_m_ / 2) return meeting;
    return at;
  }

  const QuadNet& net_;
  const Neighbourhood& around_;
  const TriangleTree& surface_;
  double spacing_m_;
  bool untangles_;                       ///< smooths the net also across the surface
  std::vector<Vec3> areas_, centroids_;  ///< of the quads
};

/// Where the net's edges do not follow a crease, points cannot slide along it. Makes connected creases
/// smooth, with points that stay, unless all their points have exactly two neighbours on them.
void releaseBrokenCreases(QuadNet& net) {
  const Neighbourhood around = neighbourhoodOf(net);
  std::vector<int> broken;
  for (std::size_t v = 0; v < net.points.size(); ++v)
    if (net.features[v] == Feature::kCrease && around.along[v].size() != 2) broken.push_back(int(v));
  while (!broken.empty()) {
    const int v = broken.back();
    broken.pop_back();
    if (net.features[v] == Feature::kSmooth) continue;
    net.features[v] = Feature::kSmooth;
    // A corner ends the creases at it, too: they meet there.
    for (const int quad : around.quads[v])
      for (int k = 0; k < 4; ++k)
        if (net.quads[quad][k] == v)
          for (const int next : {net.quads[quad][(k + 1) % 4], net.quads[quad][(k + 3) % 4]})
            if (net.features[next] != Feature::kSmooth) broken.push_back(next);
  }
}

/// Moves points to creases and corners, the nearest first, corners before creases, but no two that share a
/// quad to almost the same place. False if there are none.
bool snapToCreases(QuadNet& net, const TriangleTree& surface, double spacing_m) {
  struct Snap {
    Vec3 point = Vec3::Zero();
    Feature feature = Feature::kSmooth;
    double distance = 0;
  };
  const Neighbourhood around = neighbourhoodOf(net);
  const Round now(net, around, surface, spacing_m);
  std::vector<Snap> snaps(net.points.size());
  parallelFor(net.points.size(), kGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t v = first; v < last; ++v) {
      snaps[v].point = now.snapped(v, snaps[v].feature);
      snaps[v].distance = (snaps[v].point - net.points[v]).norm();
    }
  });
  std::vector<int> order;
  for (std::size_t v = 0; v < snaps.size(); ++v)
    if (snaps[v].feature != Feature::kSmooth) order.push_back(int(v));
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    if (snaps[a].feature != snaps[b].feature) return snaps[a].feature > snaps[b].feature;
    return snaps[a].distance != snaps[b].distance ? snaps[a].distance < snaps[b].distance : a < b;
  });
  for (const int v : order) {
    bool is_free = true;
    for (const int quad : around.quads[v])
      for (const int corner : net.quads[quad])
        is_free = is_free && (net.features[corner] == Feature::kSmooth ||
                              (net.points[corner] - snaps[v].point).norm() > kApart * spacing_m);
    if (!is_free) continue;
    net.points[v] = snaps[v].point;
    net.features[v] = snaps[v].feature;
  }
  releaseBrokenCreases(net);
  return std::any_of(net.features.begin(), net.features.end(),
                     [](Feature feature) { return feature != Feature::kSmooth; });
}

}  // namespace

Vec3 areaVector(const QuadNet& net, const std::array<int, 4>& quad) {
  return (net.points[quad[2]] - net.points[quad[0]]).cross(net.points[quad[3]] - net.points[quad[1]]) / 2;
}

void spreadEvenly(QuadNet& net, const TriangleTree& surface, double spacing_m) {
  std::vector<Vec3> moved(net.points.size());
  const auto even = [&](int rounds, int untangling) {
    const Neighbourhood around = neighbourhoodOf(net);
    for (int round = 0; round < rounds; ++round) {
      const Round now(net, around, surface, spacing_m, round < untangling);
      parallelFor(net.points.size(), kGrain, [&](std::size_t first, std::size_t last) {
        for (std::size_t v = first; v < last; ++v) moved[v] = now.moved(v);
      });
      net.points.swap(moved);
    }
  };
  std::fill(net.features.begin(), net.features.end(), Feature::kSmooth);
  even(kRounds, kUntanglingRounds);
  if (snapToCreases(net, surface, spacing_m)) even(kCreasedRounds, 0);
}

}  // namespace airclay
