// SPDX-License-Identifier: MIT
#include "capture/calibration/board_exposure.h"
#include "engine/core/median.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace airclay {
namespace {

constexpr double kStep_px = 0.25;  // between a profile's samples
constexpr double kFarthest_px = 6;
// A marker begins after a margin of the square's edge; the profile ends before it.
constexpr double kOfMargin = 0.6, kOfPlainSquare = 0.4;
constexpr int kProfiles = 7;  // beside each other, along the middle third of an edge
constexpr double kLeastContrast = 10;

/// Grey values between the pixels.
class Grey {
 public:
  Grey(ImageSize size, std::span<const std::uint8_t> bgr) : size_(size), bgr_(bgr) {}

  bool reaches(const Vec2& at) const {
    return at.x() >= 0 && at.y() >= 0 && at.x() <= size_.width - 1 && at.y() <= size_.height - 1;
  }
  /// Bilinear. \pre reaches(at)
  double operator()(const Vec2& at) const {
    const int x = std::min(static_cast<int>(at.x()), size_.width - 2),
              y = std::min(static_cast<int>(at.y()), size_.height - 2);
    const double u = at.x() - x, v = at.y() - y;
    return (1 - v) * ((1 - u) * pixel(x, y) + u * pixel(x + 1, y)) +
           v * ((1 - u) * pixel(x, y + 1) + u * pixel(x + 1, y + 1));
  }

 private:
  /// Rec. ITU-R BT.601's luma.
  double pixel(int x, int y) const {
    const std::size_t at = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(size_.width) +
                                static_cast<std::size_t>(x));
    return 0.114 * bgr_[at] + 0.587 * bgr_[at + 1] + 0.299 * bgr_[at + 2];
  }
  ImageSize size_;
  std::span<const std::uint8_t> bgr_;
};

/// The mean grey across an edge from one side to the other, every kStep_px; empty where the image ends.
std::vector<double> profileAcross(const Grey& grey, const Vec2& a, const Vec2& b, double reach_px) {
  const Vec2 along = b - a, across = Vec2(-along.y(), along.x()).normalized();
  const int half = static_cast<int>(reach_px / kStep_px);
  std::vector<double> profile;
  for (int k = -half; k <= half; ++k) {
    double sum = 0;
    for (int i = 0; i < kProfiles; ++i) {
      const Vec2 at = a + along * (1.0 / 3 + i / (3.0 * (kProfiles - 1))) + kStep_px * k * across;
      if (!grey.reaches(at)) return {};
      sum += grey(at);
    }
    profile.push_back(sum / kProfiles);
  }
  return profile;
}

struct Edge {
  double black, white, blur_px;
};

/// A blurred step's steepest slope is its height / (sigma sqrt(2 pi)).
std::optional<Edge> edgeOf(const std::vector<double>& profile) {
  constexpr std::size_t kPixel = static_cast<std::size_t>(1 / kStep_px);
  if (profile.size() < 4 * kPixel + 1) return std::nullopt;  // too small for its sides to be level
  const auto [low, high] = std::minmax(profile.front(), profile.back());
  if (high - low < kLeastContrast) return std::nullopt;
  double steepest = 0;
  for (std::size_t k = kPixel; k < profile.size(); ++k)
    steepest = std::max(steepest, std::abs(profile[k] - profile[k - kPixel]));
  // the slope is that over one pixel, and the samples lie between pixels: both are a blur of their own
  const double seen = (high - low) / (steepest * std::sqrt(2 * M_PI));
  constexpr double kOwnVariance = 1.0 / 12 + 1.0 / 6;
  return Edge{low, high, std::sqrt(std::max(0.0, seen * seen - kOwnVariance))};
}

/// From the corner `id` to the next one across the edge that leaves it to the right, or downwards; none where
/// it is not seen.
std::optional<Vec2> besideEdge(const std::map<int, Vec2>& corners, const Board& board, int id, bool right) {
  const int column = id % board.cornersX();
  for (const int step : {1, -1}) {
    if (!right && (column + step < 0 || column + step >= board.cornersX())) continue;
    const auto beside = corners.find(id + step * (right ? board.cornersX() : 1));
    if (beside != corners.end()) return Vec2(beside->second - corners.at(id));
  }
  return std::nullopt;
}

}  // namespace

std::optional<BoardExposure> boardExposure(const Board& board, const BoardView& view, ImageSize size,
                                           std::span<const std::uint8_t> bgr) {
  if (size.width < 2 || size.height < 2) return std::nullopt;
  const Grey grey(size, bgr);
  std::map<int, Vec2> corners;
  for (std::size_t i = 0; i < view.ids.size(); ++i) corners[view.ids[i]] = view.pixels[i];
  const double margin =
      board.chessboard ? kOfPlainSquare : kOfMargin * (1 - board.marker_m / board.square_m) / 2;
  const int columns = board.cornersX();
  std::vector<double> black, white, blur;
  for (const auto& [id, pixel] : corners)
    for (const bool right : {true, false}) {
      if (right && id % columns == columns - 1) continue;
      const auto next = corners.find(right ? id + 1 : id + columns);
      const std::optional<Vec2> beside = besideEdge(corners, board, id, right);
      if (next == corners.end() || !beside) continue;
      const Vec2 along = (next->second - pixel).normalized();
      // a board that is turned away has narrow squares on one side
      const double square_px = std::abs(along.x() * beside->y() - along.y() * beside->x());
      const std::optional<Edge> edge =
          edgeOf(profileAcross(grey, pixel, next->second, std::min(kFarthest_px, margin * square_px)));
      if (!edge) continue;
      black.push_back(edge->black);
      white.push_back(edge->white);
      blur.push_back(edge->blur_px);
    }
  if (blur.empty()) return std::nullopt;
  return BoardExposure{median(black), median(white), median(blur)};
}

}  // namespace airclay
