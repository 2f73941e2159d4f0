// SPDX-License-Identifier: MIT
#include "engine/silhouette/cell_reference.h"

#include <algorithm>
#include <cmath>

namespace airclay {
namespace {

/// A tile's sums, with that of image squared replaced by the squared residual at the tile's own light.
Vec3 residualSums(std::span<const float> sums, std::size_t tile, double least_light) {
  const Vec3 sum(sums[kTileSums * tile], sums[kTileSums * tile + 1], sums[kTileSums * tile + 2]);
  const double light = std::clamp(sum[0] / (sum[1] + 1), least_light, double(kMostLight));
  return {sum[0], sum[1], sum[2] - 2 * light * sum[0] + light * light * sum[1]};
}

double distanceToSegment(const Vec2& point, const Vec2& from, const Vec2& to) {
  const Vec2 along = to - from;
  const double length2 = along.squaredNorm();
  const double place = length2 > 0 ? std::clamp((point - from).dot(along) / length2, 0.0, 1.0) : 0;
  return (point - from - place * along).norm();
}

/// The number of the hand's pixels in the square of cells around cell (x, y); pixels outside the image are
/// none.
int handPixels(const Silhouette& mask, int x, int y, int cells) {
  int count = 0;
  for (int v = 2 * (y - cells); v < 2 * (y + cells + 1); ++v)
    for (int u = 2 * (x - cells); u < 2 * (x + cells + 1); ++u)
      count += u >= 0 && v >= 0 && u < mask.width && v < mask.height && mask.contains(u, v);
  return count;
}

}  // namespace

CellBackground cellBackgroundReference(int width, std::span<const std::uint32_t> model, int x, int y) {
  CellBackground cell;
  for (int k = 0; k < 4; ++k) {
    const std::uint32_t word = model[std::size_t((2 * y + k / 2) * width + 2 * x + k % 2)];
    cell.colour += Vec3(word & 255, word >> 8 & 255, word >> 16 & 255) / 4;
    cell.variance += std::pow(kSpreadStep * (word >> 24), 2) / 4;
  }
  return cell;
}

Vec3 tileSumsReference(std::span<const std::uint32_t> colours, std::span<const GpuCellBackground> background,
                       std::uint32_t tile_columns, int tile_x, int tile_y) {
  const int n = kTileCells;
  Vec3 sums = Vec3::Zero();
  for (int y = n * tile_y; y < n * (tile_y + 1); ++y)
    for (int x = n * tile_x; x < n * (tile_x + 1); ++x) {
      const auto cell = std::size_t(y * n * int(tile_columns) + x);
      const Vec3 seen = unpackColour(colours[cell]), mean = unpackColour(background[cell].colour);
      sums += Vec3(seen.dot(mean), mean.squaredNorm(), seen.squaredNorm());
    }
  return sums;
}

double textureReference(std::span<const float> sums, std::uint32_t tile_columns, const GpuTileRegion& region,
                        int x, int y, double noise, const EvidenceAssumptions& assumptions) {
  // bilinear interpolation between the tiles' centres
  const Vec2 place((x + 0.5) / kTileCells - 0.5, (y + 0.5) / kTileCells - 0.5);
  double residual = 0;
  for (int k = 0; k < 4; ++k) {
    const Vec2 tile(std::floor(place.x()) + k % 2, std::floor(place.y()) + k / 2);
    const double weight = (1 - std::abs(place.x() - tile.x())) * (1 - std::abs(place.y() - tile.y()));
    const int column = std::clamp(int(tile.x()), int(region.low[0]), int(region.high[0]) - 1);
    const int row = std::clamp(int(tile.y()), int(region.low[1]), int(region.high[1]) - 1);
    const auto index = std::size_t(row * int(tile_columns) + column);
    residual += weight * residualSums(sums, index, assumptions.least_light)[2];
  }
  const double mean = residual / (kTileCells * kTileCells) / (2 * noise);
  return std::clamp(assumptions.texture_trust * (mean - kTileNoise), -double(kTileChange),
                    double(kTileChange));
}

Silhouette evidenceMaskReference(const Camera& camera, const GpuTileRegion& region,
                                 std::span<const std::uint8_t> evidence) {
  Silhouette mask = emptySilhouette(camera);
  const int tile = kEvidenceTile, columns = int(kTileCells) * (camera.width / tile);
  for (int y = tile * int(region.low[1]); y < tile * int(region.high[1]); ++y)
    for (int x = tile * int(region.low[0]); x < tile * int(region.high[0]); ++x)
      if (evidenceOf(evidence[std::size_t(y / 2 * columns + x / 2)]) > 0)
        mask.pixels[std::size_t(y * camera.width + x)] = 255;
  return mask;
}

std::vector<std::uint8_t> maskImageReference(const Silhouette& mask) {
  std::vector<std::uint8_t> image;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) image.insert(image.end(), 3, mask.contains(x, y) ? 255 : 0);
  return image;
}

std::vector<std::uint32_t> colourCountsReference(const ColourView& view) {
  std::vector<std::uint32_t> counts(std::size_t(2) * kColourCounts);
  const int n = kTileCells, columns = n * (view.mask.width / int(kEvidenceTile));
  for (int y = n * int(view.region.low[1]); y < n * int(view.region.high[1]); ++y)
    for (int x = n * int(view.region.low[0]); x < n * int(view.region.high[0]); ++x) {
      const auto cell = std::size_t(y * columns + x);
      const int side = 2 * (2 * kInsideCells + 1);
      const bool is_hand = handPixels(view.mask, x, y, kInsideCells) == side * side;
      const bool is_other =
          handPixels(view.mask, x, y, kOutsideCells) == 0 && view.evidence[cell] % 2 == 1 &&
          distanceToSegment(Vec2(2 * x + 0.5, 2 * y + 0.5), view.arm_from, view.arm_to) > view.arm_radius;
      if (!is_hand && !is_other) continue;
      const std::size_t first = is_hand ? 0 : kColourCounts;
      ++counts[first + colourBin(unpackColour(view.colours[cell]))];
      ++counts[first + kColourTable];
    }
  return counts;
}

std::vector<double> histogramReference(std::span<const float> histogram,
                                       std::span<const std::uint32_t> counts, double rate) {
  std::vector<double> result(histogram.begin(), histogram.end());
  const double total = counts[kColourTable];
  if (total < kMinColours) return result;
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i] = (1 - rate) * result[i] + rate * counts[i] / total;
  return result;
}

}  // namespace airclay
