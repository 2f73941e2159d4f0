// SPDX-License-Identifier: MIT
#include "engine/synthetic/texture.h"

#include <cmath>

namespace airclay {

Vec3f linearFromSrgb(const Vec3& srgb) {
  return srgb.array().max(0).pow(kEncodingGamma).matrix().cast<float>();
}

NoiseVolume::NoiseVolume(std::uint32_t seed) {
  std::vector<float> values(static_cast<std::size_t>(kSide * kSide * kSide), 0.f);
  Random random(seed);
  float total = 0;
  for (int cells = 4, octave = 0; octave < 4; ++octave, cells *= 2) {
    const float height = std::pow(0.62f, static_cast<float>(octave));
    total += height;
    std::vector<float> lattice(static_cast<std::size_t>(cells * cells * cells));
    for (float& value : lattice) value = static_cast<float>(random.uniform(0, 1));
    const auto value = [&](int x, int y, int z) {
      return lattice[static_cast<std::size_t>(((z % cells) * cells + y % cells) * cells + x % cells)];
    };
    const int step = kSide / cells;
    std::size_t i = 0;
    for (int z = 0; z < kSide; ++z)
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
          const auto weight = [step](int place) {
            const float t = static_cast<float>(place % step) / static_cast<float>(step);
            return t * t * (3 - 2 * t);
          };
          const int cx = x / step, cy = y / step, cz = z / step;
          const float a = weight(x), b = weight(y), c = weight(z);
          float sum = 0;
          for (int corner = 0; corner < 8; ++corner) {
            const int dx = corner & 1, dy = corner >> 1 & 1, dz = corner >> 2;
            sum += (dx ? a : 1 - a) * (dy ? b : 1 - b) * (dz ? c : 1 - c) * value(cx + dx, cy + dy, cz + dz);
          }
          values[i++] += height * sum;
        }
  }
  for (const float value : values) values_.push_back(static_cast<std::uint8_t>(255 * value / total + 0.5f));
}

float NoiseVolume::nearest(const Vec3f& cells) const {
  return at(floorOf(cells.x()), floorOf(cells.y()), floorOf(cells.z()));
}

float NoiseVolume::smooth(const Vec3f& cells) const {
  const int x = floorOf(cells.x()), y = floorOf(cells.y()), z = floorOf(cells.z());
  const Vec3f t = cells - Vec3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
  float sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int dx = corner & 1, dy = corner >> 1 & 1, dz = corner >> 2;
    sum += (dx ? t.x() : 1 - t.x()) * (dy ? t.y() : 1 - t.y()) * (dz ? t.z() : 1 - t.z()) *
           at(x + dx, y + dy, z + dz);
  }
  return sum;
}

}  // namespace airclay
