// SPDX-License-Identifier: MIT
// Merges the points of formats that store a vertex several times.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "engine/core/math.h"

namespace airclay {

/// Appends points to a list, each position only once.
class PointMerger {
 public:
  explicit PointMerger(std::vector<Vec3>& points) : points_(points) {}

  /// The point's index.
  int add(const Vec3& point) {
    // Adding 0 makes a negative zero positive.
    const std::array<double, 3> position = {point.x() + 0., point.y() + 0., point.z() + 0.};
    const auto [known, is_new] = index_of_.try_emplace(position, int(points_.size()));
    if (is_new) points_.push_back(point);
    return known->second;
  }

 private:
  struct Hash {
    std::size_t operator()(const std::array<double, 3>& position) const {
      std::uint64_t hash = 0;
      for (const double value : position) {
        hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 0x9E3779B97F4A7C15u;
        hash ^= hash >> 32;
      }
      return std::size_t(hash);
    }
  };

  std::vector<Vec3>& points_;
  std::unordered_map<std::array<double, 3>, int, Hash> index_of_;
};

}  // namespace airclay
