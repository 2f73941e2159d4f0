// SPDX-License-Identifier: MIT
#include "engine/validation/bench_peers.h"

#include <algorithm>
#include <cmath>
#include <thread>

#include "engine/core/error.h"

namespace airclay {
namespace {

constexpr int kThreads = 2;

/// Calls body(thread) on each thread; the last one is the calling thread.
template <class Body>
void onAllThreads(Body body) {
  std::thread other([&] { body(0); });
  body(kThreads - 1);
  other.join();
}

std::array<float, 3> floats(const Vec3& v) {
  return {float(v.x()), float(v.y()), float(v.z())};
}

}  // namespace

// --- carve ---

CarveLoop::CarveLoop(const Rig& rig, int voxels)
    : voxels_(voxels), row_words_((std::size_t(voxels) + 31) / 32) {
  const double voxel_m = rig.workspace.edge_m / voxels;
  for (const Camera& camera : rig.cameras) {
    const Lens& lens = camera.lens;
    const auto& k = lens.distortion;
    if (lens.model == LensModel::kFisheye || k[5] != 0 || k[6] != 0 || k[7] != 0)
      throw Error("bench's carving loop supports lenses of five coefficients, not the lens of camera " +
                  camera.name);
    View view{};
    view.origin = floats(camera.camera_from_world * voxelCenter(rig.workspace, voxels, 0, 0, 0));
    const Mat3 step_m = voxel_m * camera.camera_from_world.linear();
    view.along_x = floats(step_m.col(0));
    view.along_y = floats(step_m.col(1));
    view.along_z = floats(step_m.col(2));
    view.fx = float(lens.fx);
    view.fy = float(lens.fy);
    view.cx = float(lens.cx + 0.5);  // so that rounding down finds the pixel
    view.cy = float(lens.cy + 0.5);
    view.k1 = float(k[0]);
    view.k2 = float(k[1]);
    view.p1 = float(k[2]);
    view.p2 = float(k[3]);
    view.k3 = float(k[4]);
    view.limit_square = float(std::min(lens.monotonic_limit * lens.monotonic_limit, 1e30));
    view.width = float(camera.width);
    view.height = float(camera.height);
    views_.push_back(view);
  }
  occupied_.resize(row_words_ * std::size_t(voxels) * std::size_t(voxels));
}

void CarveLoop::run(const std::vector<Silhouette>& masks) {
  // alternating layers: contiguous halves would contain different amounts of the hand
  onAllThreads([&](int thread) { carveLayers(masks, thread, kThreads); });
}

void CarveLoop::carveLayers(const std::vector<Silhouette>& masks, int first, int step) {
  const std::size_t cameras = views_.size();
  std::vector<const std::uint8_t*> pixels;
  for (const Silhouette& mask : masks) pixels.push_back(mask.pixels.data());
  std::vector<std::array<float, 3>> row(cameras);  // the row's first voxel in each camera's frame
  for (int z = first; z < voxels_; z += step)
    for (int y = 0; y < voxels_; ++y) {
      for (std::size_t c = 0; c < cameras; ++c)
        for (std::size_t k = 0; k < 3; ++k)
          row[c][k] = views_[c].origin[k] + float(y) * views_[c].along_y[k] + float(z) * views_[c].along_z[k];
      std::uint32_t* const words =
          &occupied_[(std::size_t(y) + std::size_t(voxels_) * std::size_t(z)) * row_words_];
      std::fill(words, words + row_words_, 0u);
      for (int x = 0; x < voxels_; ++x) {
        const float steps = float(x);
        int seen = 0;
        bool inside = true;
        for (std::size_t c = 0; c < cameras; ++c) {
          const View& view = views_[c];
          // computed from the row's first voxel, so that cameras after the first miss need no step
          const float depth = row[c][2] + steps * view.along_x[2];
          if (depth <= 0) continue;
          const float nearness = 1 / depth;
          const float u = (row[c][0] + steps * view.along_x[0]) * nearness;
          const float v = (row[c][1] + steps * view.along_x[1]) * nearness;
          const float uu = u * u, vv = v * v, uv2 = 2 * u * v, r2 = uu + vv;
          if (r2 > view.limit_square) continue;
          const float radial = 1 + r2 * (view.k1 + r2 * (view.k2 + r2 * view.k3));
          const float px = view.fx * (u * radial + view.p1 * uv2 + view.p2 * (r2 + 2 * uu)) + view.cx;
          const float py = view.fy * (v * radial + view.p1 * (r2 + 2 * vv) + view.p2 * uv2) + view.cy;
          if (!(px >= 0 && px < view.width && py >= 0 && py < view.height)) continue;
          ++seen;
          if (!pixels[c][int(py) * int(view.width) + int(px)]) {
            inside = false;
            break;
          }
        }
        if (inside && seen >= 2) words[x / 32] |= 1u << (x % 32);
      }
    }
}

// --- silhouette ---

SilhouetteLoop::SilhouetteLoop(const Rig& rig, const std::vector<std::vector<BackgroundPixel>>& backgrounds) {
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const Camera& camera = rig.cameras[c];
    std::vector<BackgroundFloats> background;
    for (const BackgroundPixel& pixel : backgrounds[c])
      background.push_back(
          {float(pixel.mean[0]), float(pixel.mean[1]), float(pixel.mean[2]), float(pixel.spread)});
    backgrounds_.push_back(std::move(background));
    const std::size_t pixels = std::size_t(camera.width) * std::size_t(camera.height);
    masks_.push_back({camera.width, camera.height, std::vector<std::uint8_t>(pixels)});
    Scratch scratch;
    scratch.octaves.resize(pixels);
    scratch.segmented.resize(pixels);
    scratch.majority.resize(pixels);
    scratch.visited.resize(pixels);
    scratch_.push_back(std::move(scratch));
  }
}

void SilhouetteLoop::run(const std::vector<std::span<const std::uint8_t>>& images) {
  onAllThreads([&](int thread) {
    for (std::size_t c = std::size_t(thread); c < images.size(); c += kThreads) segment(c, images[c]);
  });
}

namespace {

/// Pixels x0 <= x <= x1 and y0 <= y <= y1.
struct Box {
  int x0, y0, x1, y1;
};

/// Collects the connected pixels in the box with the value at `start`; returns whether they touch the box's
/// border.
bool floodFill(const std::vector<std::uint8_t>& pixels, int width, const Box& box, int start,
               bool eight_connected, std::vector<std::uint8_t>& visited, std::vector<int>& part) {
  const std::uint8_t value = pixels[std::size_t(start)];
  bool border = false;
  part.assign(1, start);
  visited[std::size_t(start)] = 1;
  const auto visit = [&](int index) {
    if (visited[std::size_t(index)] || pixels[std::size_t(index)] != value) return;
    visited[std::size_t(index)] = 1;
    part.push_back(index);
  };
  for (std::size_t next = 0; next < part.size(); ++next) {
    const int index = part[next], x = index % width, y = index / width;
    const bool left = x > box.x0, right = x<box.x1, above = y> box.y0, below = y < box.y1;
    border = border || !left || !right || !above || !below;
    if (left) visit(index - 1);
    if (right) visit(index + 1);
    if (above) visit(index - width);
    if (below) visit(index + width);
    if (!eight_connected) continue;
    if (left && above) visit(index - width - 1);
    if (right && above) visit(index - width + 1);
    if (left && below) visit(index + width - 1);
    if (right && below) visit(index + width + 1);
  }
  return border;
}

/// The bounding box of the part, enlarged by one pixel within the image.
Box boxAround(const std::vector<int>& part, int width, int height) {
  Box box{width - 1, height - 1, 0, 0};
  for (const int index : part) {
    const int x = index % width, y = index / width;
    box = {std::min(box.x0, x), std::min(box.y0, y), std::max(box.x1, x), std::max(box.y1, y)};
  }
  return {std::max(box.x0 - 1, 0), std::max(box.y0 - 1, 0), std::min(box.x1 + 1, width - 1),
          std::min(box.y1 + 1, height - 1)};
}

/// Whether an object pixel is edge blur (EdgeArgs in silhouette_io.h).
bool isSmear(const std::vector<std::int8_t>& octaves, int width, int height, int x, int y) {
  const int i = y * width + x, own = octaves[std::size_t(i)];
  if (own >= 2) return false;
  constexpr std::array<std::array<int, 2>, 4> kAxes{{{1, 0}, {0, 1}, {1, 1}, {-1, 1}}};
  for (const auto& [dx, dy] : kAxes) {
    std::array<int, 2> highest{-1, -1}, lowest{own, own};  // on either side
    for (int step = 1; step <= kSmearReach; ++step)
      for (const int side : {0, 1}) {
        const int u = x + (side ? -step : step) * dx, v = y + (side ? -step : step) * dy;
        if (u < 0 || v < 0 || u >= width || v >= height) continue;
        const int other = octaves[std::size_t(v * width + u)];
        highest[std::size_t(side)] = std::max(highest[std::size_t(side)], other);
        lowest[std::size_t(side)] = std::min(lowest[std::size_t(side)], other);
      }
    for (const std::size_t side : {0, 1})
      if (lowest[side] < 0 && highest[1 - side] >= own + 2) return true;
  }
  return false;
}

void majorityOf(const std::vector<std::uint8_t>& from, int width, int height, std::vector<std::uint8_t>& to) {
  std::vector<std::uint8_t> columns(std::size_t(width) + 2);  // sums of three rows, with a zero at both ends
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const std::size_t i = std::size_t(y * width + x);
      int sum = from[i];
      if (y > 0) sum += from[i - std::size_t(width)];
      if (y + 1 < height) sum += from[i + std::size_t(width)];
      columns[std::size_t(x) + 1] = std::uint8_t(sum);
    }
    for (int x = 0; x < width; ++x) {
      const std::size_t i = std::size_t(x);
      to[std::size_t(y * width + x)] = columns[i] + columns[i + 1] + columns[i + 2] >= 5;
    }
  }
}

}  // namespace

void SilhouetteLoop::segment(std::size_t camera, std::span<const std::uint8_t> bgr) {
  Scratch& s = scratch_[camera];
  Silhouette& mask = masks_[camera];
  const int width = mask.width, height = mask.height, count = width * height;
  const BackgroundFloats* const background = backgrounds_[camera].data();

  // each pixel's difference from the background, in octaves (scoreReference)
  for (int i = 0; i < count; ++i) {
    const BackgroundFloats& e = background[i];
    const float b = bgr[std::size_t(3 * i)], g = bgr[std::size_t(3 * i + 1)], r = bgr[std::size_t(3 * i + 2)];
    const float square = std::max(e.b * e.b + e.g * e.g + e.r * e.r, 1.0f);
    const float alpha = (b * e.b + g * e.g + r * e.r) / square;
    const float rest_b = b - alpha * e.b, rest_g = g - alpha * e.g, rest_r = r - alpha * e.r;
    const float tolerance = kColourSpreads * e.spread, slack = tolerance / std::sqrt(square);
    const float brightness =
        alpha > 1 ? (alpha - 1) / (kBrightest - 1 + slack) : (1 - alpha) / (1 - kDarkest + slack);
    const float colour = std::sqrt(rest_b * rest_b + rest_g * rest_g + rest_r * rest_r) / tolerance;
    const float score = std::max(colour, brightness);
    s.octaves[std::size_t(i)] = std::int8_t((score >= 1) + (score >= 2) + (score >= 4) + (score >= 8) - 1);
  }
  // few pixels are object pixels, and only those need isSmear()
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t i = std::size_t(y * width + x);
      s.segmented[i] = s.octaves[i] >= 0 && !isSmear(s.octaves, width, height, x, y);
    }
  majorityOf(s.segmented, width, height, s.majority);

  s.largest.clear();
  std::fill(s.visited.begin(), s.visited.end(), std::uint8_t(0));
  for (int i = 0; i < count; ++i) {
    if (!s.majority[std::size_t(i)] || s.visited[std::size_t(i)]) continue;
    floodFill(s.majority, width, {0, 0, width - 1, height - 1}, i, true, s.visited, s.part);
    if (s.part.size() > s.largest.size()) std::swap(s.part, s.largest);
  }
  std::fill(mask.pixels.begin(), mask.pixels.end(), std::uint8_t(0));
  for (const int i : s.largest) mask.pixels[std::size_t(i)] = 255;

  // holes are inside the part's box; background that reaches the box's border is outside
  std::fill(s.visited.begin(), s.visited.end(), std::uint8_t(0));
  const std::size_t largest_hole = largestHole(width);
  const Box box = boxAround(s.largest, width, height);
  for (int y = box.y0; y <= box.y1; ++y)
    for (int x = box.x0; x <= box.x1; ++x) {
      const int i = y * width + x;
      if (mask.pixels[std::size_t(i)] || s.visited[std::size_t(i)]) continue;
      if (!floodFill(mask.pixels, width, box, i, false, s.visited, s.part) && s.part.size() <= largest_hole)
        for (const int hole : s.part) mask.pixels[std::size_t(hole)] = 255;
    }
}

}  // namespace airclay
