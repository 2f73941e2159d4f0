// SPDX-License-Identifier: MIT
// The reference implementation of relax_umbrella and relax_move: point by point, in double precision.
#include <algorithm>

#include "engine/sculpt/relax.h"

namespace airclay {
namespace {

/// The average of `values` over a point's neighbours, without those on a border if `inner_only`. False if
/// there are none.
bool averageAround(const SurfaceNeighbours& neighbours, std::size_t point, bool inner_only,
                   const std::vector<Vec3>& values, Vec3& average) {
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for (std::uint32_t k = neighbours.starts[point]; k < neighbours.starts[point + 1]; ++k) {
    const std::uint32_t neighbour = neighbours.entries[k];
    if (inner_only && neighbours.borders[neighbour] != 0) continue;
    sum += values[neighbour];
    ++count;
  }
  if (count > 0) average = sum / count;
  return count > 0;
}

}  // namespace

std::vector<Vec3> relaxReference(const SurfaceNeighbours& neighbours, const std::vector<Vec3>& data_points,
                                 const std::vector<Vec3>& normals, const std::vector<double>& nearness,
                                 double strength) {
  std::vector<Vec3> across, umbrellas, displacements;
  for (std::size_t i = 0; i < data_points.size(); ++i) {
    Vec3 average = data_points[i];
    averageAround(neighbours, i, false, data_points, average);
    const Vec3 umbrella = average - data_points[i];
    across.push_back(Vec3::Zero());
    if (neighbours.borders[i] != 0) {
      const std::uint32_t* around = &neighbours.entries[neighbours.starts[i]];
      across.back() = (data_points[around[1]] - data_points[around[0]]).cross(normals[i]).stableNormalized();
    }
    umbrellas.emplace_back(umbrella.dot(normals[i]), umbrella.dot(across[i]), 0);
  }
  for (std::size_t i = 0; i < data_points.size(); ++i) {
    Vec3 average;
    displacements.push_back(Vec3::Zero());
    if (!averageAround(neighbours, i, neighbours.borders[i] == 0, umbrellas, average)) continue;
    const Vec3 bilaplacian = umbrellas[i] - average;
    displacements.back() =
        strength * nearness[i] * (bilaplacian.x() * normals[i] + bilaplacian.y() * across[i]);
  }
  return displacements;
}

double relaxNearness(const DistanceGrid& hand, const ContactPose& now, std::uint32_t mirrors,
                     const Vec3& data_point, double reach_m) {
  double distance_m = reach_m;
  for (std::uint32_t image = 0; image < imageCount(mirrors); ++image) {
    const Vec3 mirrored = mirrorOf(mirrors, image).cwiseProduct(data_point);
    distance_m = std::min(distance_m, sample(hand, now.rotation.conjugate() * (mirrored - now.position)));
  }
  const double fraction = std::clamp(distance_m / reach_m, 0.0, 1.0);
  return 1 - fraction * fraction * (3 - 2 * fraction);
}

}  // namespace airclay
