// SPDX-License-Identifier: MIT
#include "engine/sculpt/symmetry.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "shaders/sculpt/symmetry_average.comp.h"

namespace airclay {
namespace {

Vec3 signsOf(unsigned axes) {
  return Vec3(axes & 1 ? -1 : 1, axes & 2 ? -1 : 1, axes & 4 ? -1 : 1);
}

/// Finds points by position.
class PointFinder {
 public:
  explicit PointFinder(const std::vector<Vec3>& points) : points_(points) {
    for (std::size_t i = 0; i < points.size(); ++i) cells_[cellOf(points[i])].push_back(i);
  }
  /// The nearest point within kSymmetryTolerance_m.
  std::optional<std::size_t> at(const Vec3& position) const {
    std::optional<std::size_t> nearest;
    double nearest_m = kSymmetryTolerance_m;
    const Cell cell = cellOf(position);
    for (int k = 0; k < 27; ++k) {
      const auto found = cells_.find({cell[0] + k % 3 - 1, cell[1] + k / 3 % 3 - 1, cell[2] + k / 9 - 1});
      if (found == cells_.end()) continue;
      for (const std::size_t i : found->second) {
        const double distance_m = (points_[i] - position).norm();
        if (distance_m > nearest_m) continue;
        nearest = i;
        nearest_m = distance_m;
      }
    }
    return nearest;
  }

 private:
  using Cell = std::array<long, 3>;
  static Cell cellOf(const Vec3& point) {
    Cell cell;
    for (int axis = 0; axis < 3; ++axis)
      cell[std::size_t(axis)] = std::lround(point[axis] / kSymmetryTolerance_m);
    return cell;
  }

  const std::vector<Vec3>& points_;
  std::map<Cell, std::vector<std::size_t>> cells_;
};

/// Every point's mirror image; empty unless the cage is symmetric.
std::optional<std::vector<std::size_t>> partners(const PolygonMesh& cage, const PointFinder& finder,
                                                 unsigned axis) {
  std::vector<std::size_t> partner;
  std::vector<bool> taken(cage.points.size());
  for (const Vec3& point : cage.points) {
    const std::optional<std::size_t> image = finder.at(signsOf(axis).cwiseProduct(point));
    if (!image || taken[*image]) return std::nullopt;
    taken[*image] = true;
    partner.push_back(*image);
  }
  std::set<std::vector<int>> faces;  // as sorted corners, because mirroring reverses a face
  for (std::vector<int> face : cage.faces) {
    std::sort(face.begin(), face.end());
    faces.insert(face);
  }
  for (std::vector<int> face : cage.faces) {
    for (int& corner : face) corner = static_cast<int>(partner[std::size_t(corner)]);
    std::sort(face.begin(), face.end());
    if (!faces.contains(face)) return std::nullopt;
  }
  return partner;
}

/// All combinations of the given axes in ascending order from 0, 4 bits each.
std::uint32_t mirrorsOfAxes(unsigned axes) {
  std::uint32_t mirrors = 0, image = 0;
  for (unsigned some = 0; some < 8; ++some)
    if ((some & ~axes) == 0) mirrors |= some << (4 * image++);
  return mirrors;
}

}  // namespace

std::uint32_t mirrorsOf(const Symmetry& symmetry) {
  return mirrorsOfAxes((symmetry.x ? 1u : 0u) | (symmetry.y ? 2u : 0u) | (symmetry.z ? 4u : 0u));
}

std::uint32_t imageCount(std::uint32_t mirrors) {
  std::uint32_t count = 1;
  while (count < kMaxImages && mirrors >> (4 * count) != 0) ++count;
  return count;
}

Vec3 mirrorOf(std::uint32_t mirrors, std::uint32_t image) {
  return signsOf(mirrors >> (4 * image));
}

Vec3 combinedDisplacement(const std::vector<Vec3>& requests) {
  Vec3 up = Vec3::Zero(), down = Vec3::Zero();
  for (const Vec3& displacement : requests) {
    up = up.cwiseMax(displacement);
    down = down.cwiseMin(displacement);
  }
  return up + down;
}

SymmetryOrbits symmetryOrbits(const PolygonMesh& cage, const Symmetry& symmetry) {
  const PointFinder finder(cage.points);
  std::map<unsigned, std::vector<std::size_t>> partner_of;  // by axis
  unsigned axes = 0;
  for (const auto& [enabled, axis] : {std::pair(symmetry.x, 1u), {symmetry.y, 2u}, {symmetry.z, 4u}}) {
    if (!enabled) continue;
    const std::optional<std::vector<std::size_t>> partner = partners(cage, finder, axis);
    if (!partner) continue;
    partner_of[axis] = *partner;
    axes |= axis;
  }
  if (axes == 0) return {};
  SymmetryOrbits orbits{mirrorsOfAxes(axes), {}};
  std::vector<bool> seen(cage.points.size());
  for (std::size_t i = 0; i < cage.points.size(); ++i) {
    if (seen[i]) continue;
    for (std::uint32_t image = 0; image < imageCount(orbits.mirrors); ++image) {
      std::size_t point = i;
      for (const auto& [axis, partner] : partner_of)
        if ((orbits.mirrors >> (4 * image) & axis) != 0) point = partner[point];
      seen[point] = true;
      orbits.points.push_back(static_cast<std::uint32_t>(point));
    }
  }
  return orbits;
}

void averageOrbits(const SymmetryOrbits& orbits, std::vector<Vec3>& control_points) {
  const std::uint32_t images = imageCount(orbits.mirrors);
  for (std::size_t orbit = 0; orbit + images <= orbits.points.size(); orbit += images) {
    Vec3 sum = Vec3::Zero();
    for (std::uint32_t image = 0; image < images; ++image)
      sum += mirrorOf(orbits.mirrors, image).cwiseProduct(control_points[orbits.points[orbit + image]]);
    for (std::uint32_t image = 0; image < images; ++image)
      control_points[orbits.points[orbit + image]] =
          mirrorOf(orbits.mirrors, image).cwiseProduct(sum / images);
  }
}

SymmetryKeeper::SymmetryKeeper(Gpu& gpu)
    : gpu_(gpu), average_(gpu, "symmetry_average", symmetry_average_comp, {kSymmetryWorkgroup}) {}

void SymmetryKeeper::setOrbits(const SymmetryOrbits& orbits) {
  orbits_ = orbits;
  points_ = Buffer<std::uint32_t>(gpu_, orbits.points);
}

void SymmetryKeeper::recordIndirect(Recorder& recorder, const Buffer<double>& exact_points,
                                    const Buffer<vec3>& control_points, const RawBuffer& groups,
                                    std::uint64_t byte_offset) {
  if (orbits_.points.empty()) return;
  SymmetryAverageArgs args{};
  args.orbits = points_;
  args.exact_points = exact_points;
  args.control_points = control_points;
  args.orbit_count = static_cast<std::uint32_t>(points_.count()) / imageCount(orbits_.mirrors);
  args.mirrors = orbits_.mirrors;
  recorder.dispatchIndirect(average_, args, groups, byte_offset);
}

}  // namespace airclay
