// SPDX-License-Identifier: MIT
// The reference implementation of the evidence kernels: serial, in double precision.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/silhouette/evidence.h"

namespace airclay {
namespace {

Vec3 bgr(std::uint32_t word) {
  return Vec3(word & 255, word >> 8 & 255, word >> 16 & 255);
}

double binCenter(std::size_t bin) {
  return kLeastGain + (double(bin) + 0.5) / kGainBins;
}

}  // namespace

std::uint32_t colourBin(const Vec3& colour) {
  std::uint32_t index = 0;
  for (int k = 0; k < 3; ++k)
    index = index * kColourBins +
            std::min(static_cast<std::uint32_t>(colour[k] * kColourBins / 256), kColourBins - 1);
  return index;
}

Vec3 gainReference(int width, int height, std::span<const std::uint8_t> image,
                   std::span<const std::uint32_t> model) {
  Vec3 gains = Vec3::Ones();
  const int step = kGainStep;
  for (int channel = 0; channel < 3; ++channel) {
    std::vector<double> bins(kGainBins);
    double total = 0;
    for (int y = step / 2; y / step < height / step; y += step)
      for (int x = step / 2; x / step < width / step; x += step) {
        const std::size_t pixel = std::size_t(y) * std::size_t(width) + std::size_t(x);
        const int seen = image[3 * pixel + std::size_t(channel)];
        const int mean = int(bgr(model[pixel])[channel]);
        if (seen > int(kGainSaturated) || mean > int(kGainSaturated) || mean < int(kGainDark)) continue;
        const double ratio = (seen + double(kGainOffset)) / (mean + double(kGainOffset));
        const double bin = std::floor((ratio - kLeastGain) * kGainBins);
        if (bin < 0 || bin >= kGainBins) continue;
        ++bins[std::size_t(bin)];
        ++total;
      }
    if (total == 0) continue;
    std::size_t median = 0;
    for (double below = bins[0]; median + 1 < kGainBins && 2 * below < total; below += bins[median]) ++median;
    double gain = binCenter(median);
    for (std::uint32_t round = 0; round < kGainRounds; ++round) {
      double sum = 0, weight = 0;
      for (std::size_t i = 0; i < kGainBins; ++i)
        if (std::abs(binCenter(i) - gain) < kGainSpread * gain) {
          sum += bins[i] * binCenter(i);
          weight += bins[i];
        }
      if (weight > 0) gain = sum / weight;
    }
    gains[channel] = gain;
  }
  return gains;
}

Vec3 cellColourReference(int width, std::span<const std::uint8_t> image, const Vec3& gain, int x, int y) {
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < 4; ++k) {
    const std::size_t pixel = std::size_t(2 * y + k / 2) * std::size_t(width) + std::size_t(2 * x + k % 2);
    for (int channel = 0; channel < 3; ++channel)
      sum[channel] += image[3 * pixel + std::size_t(channel)] / (4 * gain[channel]);
  }
  return sum.cwiseMin(1023 * double(kCellColourStep));
}

double lightReference(std::span<const float> sums, std::uint32_t columns, const GpuTileRegion& region, int x,
                      int y, double least_light) {
  // the cell's position in tiles, from the first tile's centre
  const double u = (x + 0.5) / kTileCells - 0.5, v = (y + 0.5) / kTileCells - 0.5;
  const int left = int(std::floor(u)), top = int(std::floor(v));
  double seen = 0, background = 0;
  for (int dy = 0; dy < 2; ++dy)
    for (int dx = 0; dx < 2; ++dx) {
      const double weight = (dx ? u - left : 1 - (u - left)) * (dy ? v - top : 1 - (v - top));
      const int tile_x = std::clamp(left + dx, int(region.low[0]), int(region.high[0]) - 1);
      const int tile_y = std::clamp(top + dy, int(region.low[1]), int(region.high[1]) - 1);
      const std::size_t tile = std::size_t(tile_y) * columns + std::size_t(tile_x);
      seen += weight * sums[kTileSums * tile];
      background += weight * sums[kTileSums * tile + 1];
    }
  return std::clamp(seen / (background + 1), least_light, double(kMostLight));
}

AdaptedPixel adaptReference(const AdaptedPixel& before, const Vec3& seen) {
  Vec3 rounded;
  for (int k = 0; k < 3; ++k) rounded[k] = std::min(std::floor(seen[k] + 0.5), 255.0);
  const auto isWithin = [&](double levels, const Vec3& other) {
    return (rounded - other).cwiseAbs().maxCoeff() <= levels;
  };
  const auto packed = [](const Vec3& colour) {
    return std::uint32_t(colour[0]) | std::uint32_t(colour[1]) << 8 | std::uint32_t(colour[2]) << 16;
  };
  const std::uint32_t spread = before.model & 0xff000000u;
  AdaptedPixel after{before.model, packed(rounded)};
  if (!isWithin(kAdaptNoise, bgr(before.model)) && isWithin(kAdaptSame, bgr(before.candidate))) {
    const std::uint32_t visits = (before.candidate >> 24) + 1, other = before.candidate & 0xffffffu;
    if (visits >= kAdaptVisits)
      after = {other | spread, other};
    else
      after.candidate = other | visits << 24;
  }
  return after;
}

CellEvidence evidenceReference(const Vec3& seen, const Vec3& background, double variance, double light,
                               double texture, double hand, double other) {
  const double noise = variance + std::pow(kTextureNoise * seen.mean(), 2);
  const double distance = (seen - light * background).squaredNorm() / (2 * noise) + texture;
  const auto beyond = [](double value, double spread) { return std::pow(std::max(0.0, value) / spread, 2); };
  const double unlikely =
      beyond(kDimmest - light, kDimmerSpread) + beyond(light - kBrighter, kBrighterSpread);
  const double density = std::pow(256.0, 3) * std::exp(-std::clamp(distance, 0.0, 40.0) - unlikely) /
                         std::pow(2 * std::numbers::pi * noise, 1.5);
  CellEvidence result;
  const double ratio = std::log(hand / (kBackgroundPrior * density + (1 - double(kBackgroundPrior)) * other));
  result.log_ratio = std::clamp(ratio, -double(kMaxEvidence), double(kMaxEvidence));
  result.change = (distance + beyond(kChangedLight - light, kChangedLightSpread)) / kChangedResidual;
  return result;
}

std::vector<double> colourTableReference(std::span<const float> histogram, double uniform) {
  const int n = kColourBins;
  const auto at = [&](int x, int y, int z) {
    const auto inside = [n](int i) { return std::size_t(std::clamp(i, 0, n - 1)); };
    return double(histogram[(inside(x) * kColourBins + inside(y)) * kColourBins + inside(z)]);
  };
  std::vector<double> table;
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y)
      for (int z = 0; z < n; ++z) {
        double sum = 0;
        for (int k = 0; k < 27; ++k) {
          const int dx = k / 9 - 1, dy = k / 3 % 3 - 1, dz = k % 3 - 1;
          sum += (2 - std::abs(dx)) * (2 - std::abs(dy)) * (2 - std::abs(dz)) / 64.0 *
                 at(x + dx, y + dy, z + dz);
        }
        table.push_back((1 - uniform) * kColourTable * sum + uniform);
      }
  return table;
}

}  // namespace airclay
