// SPDX-License-Identifier: MIT
// The reference implementation of the silhouette kernels: serial, in double precision.
#include <algorithm>
#include <cmath>
#include <queue>

#include "engine/silhouette/silhouette.h"

namespace airclay {
namespace {

/// Calls `visit` for each connected part of object or background pixels, with its pixel indices and whether
/// it touches the border.
template <class Visit>
void forEachPart(const Silhouette& mask, bool object, bool eight_connected, Visit visit) {
  std::vector<char> done(mask.pixels.size());
  for (std::size_t start = 0; start < mask.pixels.size(); ++start) {
    if (done[start] || (mask.pixels[start] != 0) != object) continue;
    std::vector<std::size_t> part{start};
    done[start] = 1;
    bool border = false;
    for (std::size_t next = 0; next < part.size(); ++next) {
      const int x = static_cast<int>(part[next]) % mask.width, y = static_cast<int>(part[next]) / mask.width;
      border = border || x == 0 || y == 0 || x + 1 == mask.width || y + 1 == mask.height;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          if (!eight_connected && dx != 0 && dy != 0) continue;
          const int u = x + dx, v = y + dy;
          if (u < 0 || v < 0 || u >= mask.width || v >= mask.height) continue;
          const std::size_t index = std::size_t(v) * std::size_t(mask.width) + std::size_t(u);
          if (done[index] || (mask.pixels[index] != 0) != object) continue;
          done[index] = 1;
          part.push_back(index);
        }
    }
    visit(part, border);
  }
}

}  // namespace

std::vector<BackgroundPixel> learnBackgroundReference(const std::vector<std::vector<std::uint8_t>>& frames) {
  std::vector<BackgroundPixel> model(frames.front().size() / 3);
  const double n = static_cast<double>(frames.size());
  for (std::size_t i = 0; i < model.size(); ++i) {
    const auto value = [&](const std::vector<std::uint8_t>& frame) {
      return Vec3(frame[3 * i], frame[3 * i + 1], frame[3 * i + 2]);
    };
    for (const auto& frame : frames) model[i].mean += value(frame) / n;
    double variance = 0;
    for (const auto& frame : frames) variance += (value(frame) - model[i].mean).squaredNorm();
    if (frames.size() > 1) variance /= 3 * (n - 1);
    model[i].spread = std::max(std::sqrt(variance), double(kMinSpread));
  }
  return model;
}

double scoreReference(const Vec3& seen, const BackgroundPixel& background) {
  const double square = std::max(background.mean.squaredNorm(), 1.0);
  const double alpha = seen.dot(background.mean) / square;
  const double tolerance = double(kColourSpreads) * background.spread;
  const double slack = tolerance / std::sqrt(square);
  const double colour = (seen - alpha * background.mean).norm() / tolerance;
  const double brightness = alpha > 1 ? (alpha - 1) / (double(kBrightest) - 1 + slack)
                                      : (1 - alpha) / (1 - double(kDarkest) + slack);
  return std::max(colour, brightness);
}

Silhouette edgesReference(int width, int height, const std::vector<double>& scores) {
  Silhouette mask{width, height, std::vector<std::uint8_t>(scores.size())};
  const auto octave = [](double score) {
    return score >= 8 ? 3 : score >= 4 ? 2 : score >= 2 ? 1 : score >= 1 ? 0 : -1;
  };
  const auto inside = [&](int u, int v) { return u >= 0 && v >= 0 && u < width && v < height; };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int own = octave(scores[std::size_t(y * width + x)]);
      bool smear = false;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          int highest = -1, lowest = own;  // on this side; on the opposite side
          for (int step = 1; step <= kSmearReach; ++step) {
            const int u = x + step * dx, v = y + step * dy, u2 = x - step * dx, v2 = y - step * dy;
            if (inside(u, v)) highest = std::max(highest, octave(scores[std::size_t(v * width + u)]));
            if (inside(u2, v2)) lowest = std::min(lowest, octave(scores[std::size_t(v2 * width + u2)]));
          }
          smear = smear || (lowest < 0 && highest >= own + 2);
        }
      mask.pixels[std::size_t(y * width + x)] = own >= 0 && !smear ? 255 : 0;
    }
  return mask;
}

Silhouette majorityReference(const Silhouette& mask) {
  Silhouette result = mask;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      int set = 0;
      for (int v = std::max(y - 1, 0); v <= std::min(y + 1, mask.height - 1); ++v)
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, mask.width - 1); ++u)
          set += mask.pixels[std::size_t(v) * std::size_t(mask.width) + std::size_t(u)] != 0;
      result.pixels[std::size_t(y) * std::size_t(mask.width) + std::size_t(x)] = set >= 5 ? 255 : 0;
    }
  return result;
}

Silhouette largestPartReference(const Silhouette& mask) {
  std::vector<std::size_t> largest;
  forEachPart(mask, true, true, [&](const std::vector<std::size_t>& part, bool) {
    if (part.size() > largest.size()) largest = part;
  });
  Silhouette result{mask.width, mask.height, std::vector<std::uint8_t>(mask.pixels.size())};
  for (const std::size_t index : largest) result.pixels[index] = 255;
  return result;
}

Silhouette closeHolesReference(const Silhouette& mask, std::uint32_t largest_hole) {
  Silhouette result = mask;
  forEachPart(mask, false, false, [&](const std::vector<std::size_t>& part, bool border) {
    if (!border && part.size() <= largest_hole)
      for (const std::size_t index : part) result.pixels[index] = 255;
  });
  return result;
}

}  // namespace airclay
