// SPDX-License-Identifier: MIT
// The reference implementation of the search's kernels: serial, in double precision.
#include <algorithm>
#include <cmath>

#include "engine/hand/hand_search.h"

namespace airclay {
namespace {

/// The probability of the hand in the block at a pixel; empty outside the tiles.
std::optional<double> probabilityAt(const GpuCamera& camera, std::span<const std::uint32_t> blocks,
                                    const Vec2& pixel) {
  const auto [columns, rows] = tilesOf(camera);
  const double x = std::floor((pixel.x() + 0.5) / kBlockPixels),
               y = std::floor((pixel.y() + 0.5) / kBlockPixels);
  if (!(x >= 0 && y >= 0 && x < 2 * columns && y < 2 * rows)) return std::nullopt;
  const auto u = std::uint32_t(x), v = std::uint32_t(y);
  const std::uint32_t word = blocks[firstTile(camera) + v / 2 * columns + u / 2];
  return double(word >> (16 * (v % 2) + 8 * (u % 2)) & 255) / 255;
}

double distanceToSegment(const Vec2& point, const Vec2& from, const Vec2& to) {
  const Vec2 along = to - from;
  const double length2 = along.squaredNorm();
  const double place = length2 > 0 ? std::clamp((point - from).dot(along) / length2, 0.0, 1.0) : 0;
  return (point - from - place * along).norm();
}

/// The cells of the score's window that a pose covers.
class Window {
 public:
  void cover(int x, int y) {
    if (isInside(x, y)) covered_[index(x, y)] = 1;
  }
  bool isCovered(int x, int y) const { return isInside(x, y) && covered_[index(x, y)] != 0; }
  /// Whether a covered cell is within the margin, in the square around the cell.
  bool isNear(int x, int y) const {
    const int margin = kScoreMargin;
    for (int v = y - margin; v <= y + margin; ++v)
      for (int u = x - margin; u <= x + margin; ++u)
        if (isCovered(u, v)) return true;
    return false;
  }

 private:
  static constexpr int kSize = kScoreWindow;
  static bool isInside(int x, int y) { return x >= 0 && y >= 0 && x < kSize && y < kSize; }
  static std::size_t index(int x, int y) { return std::size_t(y * kSize + x); }
  std::vector<char> covered_ = std::vector<char>(std::size_t(kSize) * kSize);
};

}  // namespace

double blockReference(std::span<const std::uint8_t> evidence, std::uint32_t tile_columns, int x, int y) {
  const auto columns = int(kTileCells * tile_columns);
  double sum = 0;
  for (int k = 0; k < 4; ++k) {
    const int cell = (2 * y + k / 2) * columns + 2 * x + k % 2;
    sum += 1 / (1 + std::exp(-evidenceOf(evidence[std::size_t(cell)])));
  }
  return sum / 4;
}

std::optional<double> hullReference(const GpuRig& rig, std::span<const std::uint32_t> blocks,
                                    std::uint32_t bits, const Vec3& point) {
  double sum = 0;
  int cameras = 0, seen = 0;
  for (std::size_t k = 0; k < rig.cameraCount(); ++k) {
    if ((bits >> k & 1) == 0) continue;
    ++cameras;
    const Camera& camera = rig.rig().cameras[k];
    const std::optional<Vec2> pixel =
        projectThroughLens(camera.lens, camera.camera_from_world * (rig.rig().workspace.center + point));
    std::optional<double> probability;
    if (pixel) probability = probabilityAt(rig.camera(k), blocks, *pixel);
    seen += probability.has_value();
    sum += std::log(std::clamp(probability.value_or(0.5), double(kHullLeast), 1 - double(kHullLeast)));
  }
  if (seen < 2) return std::nullopt;
  return sum / cameras;
}

double scoreReference(const GpuRig& rig, std::size_t camera_index, const OutlineModel& model,
                      const GpuOutlineFrame& frame, const GpuOutlinePose& pose,
                      std::span<const std::uint32_t> blocks) {
  const Camera& camera = rig.rig().cameras[camera_index];
  const Mat3 turn = double(pose.scale) * rotationOf(pose);
  const auto inCamera = [&](const Vec3& in_hand) {
    return Vec3(camera.camera_from_world *
                (rig.rig().workspace.center + pose.position.cast<double>() + turn * in_hand));
  };
  const Vec3 center = inCamera(Vec3::Zero());
  if (center.z() <= kNearest) return -1;
  const double blocks_per_cell =
      std::max(1.0, std::floor(camera.lens.fx * kScoreCell / (center.z() * kBlockPixels) + 0.5));
  const double cell_pixels = blocks_per_cell * kBlockPixels;
  const auto cellAt = [&](const Vec2& pixel) {
    return Eigen::Vector2i(int(std::floor((pixel.x() + 0.5) / cell_pixels)),
                           int(std::floor((pixel.y() + 0.5) / cell_pixels)));
  };
  const std::optional<Vec2> center_pixel = projectThroughLens(camera.lens, center);
  if (!center_pixel) return -1;
  const Eigen::Vector2i origin = cellAt(*center_pixel) - Eigen::Vector2i::Constant(kScoreWindow / 2);

  Window window;
  for (const vec3& point : model.points)
    if (const auto pixel = projectThroughLens(camera.lens, inCamera(point.cast<double>()))) {
      const Eigen::Vector2i cell = cellAt(*pixel) - origin;
      window.cover(cell.x(), cell.y());
    }
  const Vec3 from = inCamera(frame.arm_from.cast<double>());
  Vec3 to = inCamera(frame.arm_to.cast<double>());
  if (to.z() < kNearest) to = from + std::max(0.0, (kNearest - from.z()) / (to.z() - from.z())) * (to - from);
  const auto arm_from = projectThroughLens(camera.lens, from), arm_to = projectThroughLens(camera.lens, to);
  const double arm_radius =
      camera.lens.fx * pose.scale * frame.arm_radius / std::max(double(kNearest), from.z());

  double difference = 0;
  std::uint32_t count = 0;
  for (int y = 0; y < int(kScoreWindow); ++y)
    for (int x = 0; x < int(kScoreWindow); ++x) {
      if (!window.isNear(x, y)) continue;
      const Vec2 pixel = cell_pixels * Vec2(origin.x() + x + 0.5, origin.y() + y + 0.5) - Vec2(0.5, 0.5);
      const std::optional<double> probability = probabilityAt(rig.camera(camera_index), blocks, pixel);
      if (!probability) continue;
      const bool is_hand = window.isCovered(x, y);
      count += is_hand;
      if (arm_from && arm_to && distanceToSegment(pixel, *arm_from, *arm_to) < arm_radius) continue;
      difference += std::pow((is_hand ? 1 : 0) - *probability, 2);
    }
  return count >= kScoreLeast ? difference / count : -1;
}

}  // namespace airclay
