// SPDX-License-Identifier: MIT
// Colours and procedural noise for the rendered room.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "engine/core/math.h"

namespace airclay {

using Vec3f = Eigen::Vector3f;

/// Linear light from an sRGB colour, 0 to 1, by the pure power law with which the room's cameras encode
/// (exponent 2.2): a gain of linear light is then a gain of the image too.
Vec3f linearFromSrgb(const Vec3& srgb);
inline constexpr double kEncodingGamma = 2.2;

/// Repeatable random numbers: the same on every platform, unlike the standard's distributions.
class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_()) + 0.5) / 4294967296.0;
  }

 private:
  std::mt19937 engine_;
};

/// The largest integer that is not above `x`: faster than std::floor, a function call on the oldest
/// processors. \pre |x| < 2²⁰
inline int floorOf(float x) {
  const int truncated = static_cast<int>(x);
  return truncated - (x < static_cast<float>(truncated));
}

/// Fractal value noise on a lattice that repeats after kSide cells: 0 to 1, mean about 1/2, with features of
/// 2 to 16 cells.
class NoiseVolume {
 public:
  explicit NoiseVolume(std::uint32_t seed);

  /// The nearest cell's value.
  float nearest(const Vec3f& cells) const;
  /// Trilinear interpolation.
  float smooth(const Vec3f& cells) const;

 private:
  static constexpr int kSide = 64;
  float at(int x, int y, int z) const {
    constexpr int kMask = kSide - 1;
    const int i = ((z & kMask) * kSide + (y & kMask)) * kSide + (x & kMask);
    return (1 / 255.f) * static_cast<float>(values_[static_cast<std::size_t>(i)]);
  }
  std::vector<std::uint8_t> values_;  ///< of 255: a quarter of a float's memory, which stays in the cache
};

}  // namespace airclay
