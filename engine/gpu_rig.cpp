// SPDX-License-Identifier: MIT
#include "engine/gpu_rig.h"

#include <algorithm>
#include <cmath>

#include "engine/error.h"

namespace airclay {
namespace {

/// The undistorted position, as GpuCamera measures it, of the ray through a pixel; the lens' limit where none
/// arrives.
double positionOfPixel(const Lens& lens, const Vec2& pixel) {
  const std::optional<Vec3> ray = rayThroughPixel(lens, pixel);
  if (!ray) return lens.monotonic_limit;
  const double across = ray->head<2>().norm();
  return lens.model == LensModel::kFisheye ? std::atan2(across, ray->z()) : across / ray->z();
}

/// The farthest undistorted position in the picture: that of a border pixel.
double farthestVisible(const Camera& camera) {
  constexpr int samples = 64;
  double farthest = 0;
  for (int i = 0; i <= samples; ++i) {
    const double u = -0.5 + camera.width * i / double(samples),
                 v = -0.5 + camera.height * i / double(samples);
    for (const Vec2& pixel :
         {Vec2(u, -0.5), Vec2(u, camera.height - 0.5), Vec2(-0.5, v), Vec2(camera.width - 0.5, v)})
      farthest = std::max(farthest, positionOfPixel(camera.lens, pixel));
  }
  return 1.01 * farthest;  // between the samples
}

/// The largest singular value of the distortion's Jacobian up to `reach`: by central differences on a polar
/// grid.
double steepness(const Lens& lens, double reach) {
  Lens unit = lens;
  unit.fx = unit.fy = 1;
  unit.cx = unit.cy = 0;
  double steepest = 0;
  constexpr int rings = 100, spokes = 16;
  for (int ring = 0; ring <= rings; ++ring)
    for (int spoke = 0; spoke < spokes; ++spoke) {
      const double position = reach * ring / rings, angle = 2 * M_PI * spoke / spokes;
      constexpr double h = 1e-6;
      // two orthonormal directions of change: outwards, and around the axis
      const auto at = [&](double out, double around) -> std::optional<Vec2> {
        Vec3 p;
        if (lens.model == LensModel::kFisheye) {
          const double theta = position + out;
          p = Vec3(std::sin(theta), around, std::cos(theta));
        } else {
          p = Vec3(position + out, around, 1);
        }
        return projectThroughLens(unit, Eigen::AngleAxisd(angle, Vec3::UnitZ()) * p);
      };
      const auto out0 = at(-h, 0), out1 = at(h, 0), around0 = at(0, -h), around1 = at(0, h);
      if (!out0 || !out1 || !around0 || !around1) continue;
      Eigen::Matrix2d jacobian;
      jacobian << (*out1 - *out0) / (2 * h), (*around1 - *around0) / (2 * h);
      // σ₁² of a 2 x 2 matrix from its invariants
      const double sum = jacobian.squaredNorm(), determinant = jacobian.determinant();
      const double square = 0.5 * (sum + std::sqrt(std::max(0.0, sum * sum - 4 * determinant * determinant)));
      steepest = std::max(steepest, std::sqrt(square));
    }
  return 1.02 * steepest;  // between the samples
}

}  // namespace

GpuCamera gpuCamera(const Camera& camera, const Workspace& workspace) {
  GpuCamera gpu{};
  gpu.rotation = camera.camera_from_world.linear().cast<float>();
  gpu.translation = (camera.camera_from_world * workspace.center).cast<float>();
  const Lens& lens = camera.lens;
  gpu.focal = Vec2(lens.fx, lens.fy).cast<float>();
  gpu.center = Vec2(lens.cx, lens.cy).cast<float>();
  for (std::size_t i = 0; i < 8; ++i) gpu.distortion[i] = static_cast<float>(lens.distortion[i]);
  const bool straight =
      std::all_of(lens.distortion.begin(), lens.distortion.end(), [](double k) { return k == 0; });
  gpu.lens = lens.model == LensModel::kFisheye ? kLensFisheye : straight ? kLensPinhole : kLensPerspective;
  gpu.width = static_cast<std::uint32_t>(camera.width);
  gpu.height = static_cast<std::uint32_t>(camera.height);
  // its square must stay a float
  gpu.limit = static_cast<float>(std::min(lens.monotonic_limit, 1e18));
  const double visible = std::min(farthestVisible(camera), lens.monotonic_limit);
  gpu.visible = static_cast<float>(visible);
  gpu.steepness = static_cast<float>(steepness(lens, std::min(1.1 * visible, lens.monotonic_limit)));
  return gpu;
}

GpuRig::GpuRig(Gpu& gpu, const Rig& rig) : rig_(rig) {
  static_assert(kMaxCameras <= 32, "a camera's number is a bit in one word of the carve kernels");
  if (rig.cameras.size() > kMaxCameras)
    throw Error("the rig has " + std::to_string(rig.cameras.size()) + " cameras; at most " +
                std::to_string(kMaxCameras));
  for (const Camera& camera : rig.cameras) {
    GpuCamera c = gpuCamera(camera, rig.workspace);
    c.row_words = (c.width + 31) / 32;
    c.mask_words = mask_words_;
    // tiles of 4 pixels: below them the tables cost more than the voxels that they save
    c.tile = 4;
    c.tiles_x = (c.width + c.tile - 1) / c.tile;
    c.tiles_y = (c.height + c.tile - 1) / c.tile;
    c.table_words = table_words_;
    c.picture_words = picture_words_;
    c.pixels_before = pixels_;
    picture_words_ += (3 * c.width * c.height + 3) / 4;
    pixels_ += c.width * c.height;
    max_pixels_ = std::max(max_pixels_, c.width * c.height);
    mask_words_ += c.row_words * c.height;
    table_words_ += 2 * (c.tiles_x + 1) * (c.tiles_y + 1);
    max_rows_ = std::max(max_rows_, c.height);
    max_row_words_ = std::max(max_row_words_, c.row_words);
    max_tile_lines_ = std::max({max_tile_lines_, c.tiles_x, c.tiles_y});
    host_cameras_.push_back(c);
  }
  cameras_ = Buffer<GpuCamera>(gpu, host_cameras_);
}

void GpuRig::pack(const std::vector<Mask>& masks, std::span<std::uint32_t> words) const {
  std::fill(words.begin(), words.end(), 0u);
  for (std::size_t m = 0; m < masks.size(); ++m) {
    const GpuCamera& camera = host_cameras_[m];
    for (std::uint32_t y = 0; y < camera.height; ++y) {
      const std::uint8_t* row = masks[m].pixels.data() + std::size_t(y) * camera.width;
      std::uint32_t* packed = words.data() + camera.mask_words + y * camera.row_words;
      for (std::uint32_t x = 0; x < camera.width; ++x)
        packed[x / 32] |= std::uint32_t(row[x] != 0) << (x % 32);
    }
  }
}

std::vector<Mask> GpuRig::unpack(std::span<const std::uint32_t> words) const {
  std::vector<Mask> masks;
  for (const GpuCamera& camera : host_cameras_) {
    Mask mask{static_cast<int>(camera.width), static_cast<int>(camera.height), {}};
    mask.pixels.resize(std::size_t(camera.width) * camera.height);
    for (std::uint32_t y = 0; y < camera.height; ++y)
      for (std::uint32_t x = 0; x < camera.width; ++x)
        mask.pixels[std::size_t(y) * camera.width + x] =
            words[camera.mask_words + y * camera.row_words + x / 32] >> (x % 32) & 1 ? 255 : 0;
    masks.push_back(std::move(mask));
  }
  return masks;
}

}  // namespace airclay
