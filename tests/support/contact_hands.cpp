// SPDX-License-Identifier: MIT
#include "tests/support/contact_hands.h"

#include "engine/clay/presets.h"
#include "engine/clay/subdivide.h"

namespace airclay {
namespace {

HandModel handOf(const std::vector<Vec3>& points, const std::vector<std::array<int, 4>>& quads) {
  HandModel hand;
  hand.skin.vertices = points;
  for (const std::array<int, 4>& quad : quads) {
    hand.skin.triangles.push_back({quad[0], quad[1], quad[2]});
    hand.skin.triangles.push_back({quad[0], quad[2], quad[3]});
  }
  return hand;
}

}  // namespace

HandModel ballHand(double radius_m) {
  const PolygonMesh cage = presetCage("ball");
  const Subdivision subdivision = subdivide(cage, 3, SubdivisionRule::kCatmullClark);
  std::vector<Vec3> points = dataPoints(subdivision.matrix, cage.points);
  for (Vec3& point : points) point *= radius_m / point.norm();
  return handOf(points, subdivision.quads);
}

HandModel boxHand(const Vec3& size_m) {
  std::vector<Vec3> points;
  for (int corner = 0; corner < 8; ++corner)
    points.push_back(
        0.5 * size_m.cwiseProduct(Vec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1)));
  return handOf(points, {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}});
}

GpuHandPose gpuHandAt(const Vec3& position_m, const Eigen::Quaterniond& rotation) {
  GpuHandPose hand = noHandPose();
  hand.rotation = rotation.coeffs().cast<float>();
  hand.position = position_m.cast<float>();
  hand.tracked = 1;
  return hand;
}

GpuHandPose lostHand() {
  GpuHandPose hand = gpuHandAt(Vec3(9, 9, 9));
  hand.tracked = 0;
  return hand;
}

}  // namespace airclay
