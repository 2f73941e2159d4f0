// SPDX-License-Identifier: MIT
#include "engine/camera/gpu_rig.h"

#include <algorithm>
#include <cmath>

#include "engine/core/error.h"
#include "shaders/hull/carve_io.h"

namespace airclay {
namespace {

static_assert(sizeof(GpuCamera) == 152, "lens.glsl loads it by this size");

/// The undistorted position (r or θ, as in GpuCamera::visible) of the ray through a pixel; the lens model's
/// limit if no ray reaches the pixel.
double positionOfPixel(const Lens& lens, const Vec2& pixel) {
  const std::optional<Vec3> ray = rayThroughPixel(lens, pixel);
  if (!ray) return lens.monotonic_limit;
  const double across = ray->head<2>().norm();
  return lens.model == LensModel::kFisheye ? std::atan2(across, ray->z()) : across / ray->z();
}

/// The largest undistorted position in the image; it occurs at the border.
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
  return 1.01 * farthest;  // margin for positions between the samples
}

/// The largest partial derivatives of the distortion up to `reach`, by central differences on a polar grid:
/// {of a coordinate with respect to itself, to the other one}; for the fisheye, {of the image position with
/// respect to the angle, 0}.
std::pair<double, double> maxStretch(const Lens& lens, double reach) {
  Lens unit = lens;
  unit.fx = unit.fy = 1;
  unit.cx = unit.cy = 0;
  const bool fisheye = lens.model == LensModel::kFisheye;
  double same = 0, cross = 0;
  constexpr int rings = 100, spokes = 16;
  for (int ring = 0; ring <= rings; ++ring)
    for (int spoke = 0; spoke < spokes; ++spoke) {
      const double position = reach * ring / rings, angle = 2 * M_PI * spoke / spokes;
      constexpr double h = 1e-6;
      const Vec2 x = position * Vec2(std::cos(angle), std::sin(angle));
      const auto at = [&](double dx, double dy) -> std::optional<Vec2> {
        if (!fisheye) return projectThroughLens(unit, Vec3(x.x() + dx, x.y() + dy, 1));
        // two orthonormal directions: away from the axis, and around it
        const Vec3 p(std::sin(position + dx), dy, std::cos(position + dx));
        return projectThroughLens(unit, Eigen::AngleAxisd(angle, Vec3::UnitZ()) * p);
      };
      const auto x0 = at(-h, 0), x1 = at(h, 0), y0 = at(0, -h), y1 = at(0, h);
      if (!x0 || !x1 || !y0 || !y1) continue;
      Eigen::Matrix2d jacobian;
      jacobian << (*x1 - *x0) / (2 * h), (*y1 - *y0) / (2 * h);
      if (fisheye) {
        same = std::max({same, jacobian.col(0).norm(), jacobian.col(1).norm()});
      } else {
        same = std::max({same, std::abs(jacobian(0, 0)), std::abs(jacobian(1, 1))});
        cross = std::max({cross, std::abs(jacobian(0, 1)), std::abs(jacobian(1, 0))});
      }
    }
  return {1.02 * same, 1.02 * cross};  // margin for positions between the samples
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
  const bool rational = lens.distortion[5] != 0 || lens.distortion[6] != 0 || lens.distortion[7] != 0;
  gpu.lens = lens.model == LensModel::kFisheye ? kLensFisheye
             : straight                        ? kLensPinhole
             : rational                        ? kLensRational
                                               : kLensPerspective;
  gpu.width = static_cast<std::uint32_t>(camera.width);
  gpu.height = static_cast<std::uint32_t>(camera.height);
  // its square must be finite in single precision
  gpu.limit = static_cast<float>(std::min(lens.monotonic_limit, 1e18));
  const double visible = std::min(farthestVisible(camera), lens.monotonic_limit);
  gpu.visible = static_cast<float>(visible);
  const auto [same, cross] = maxStretch(lens, std::min(1.1 * visible, lens.monotonic_limit));
  gpu.max_stretch = static_cast<float>(same);
  gpu.max_cross_stretch = static_cast<float>(cross);
  return gpu;
}

GpuRig::GpuRig(Gpu& gpu, const Rig& rig) : rig_(rig) {
  static_assert(kMaxCameras <= 32, "the carve kernels keep one bit per camera in a 32-bit word");
  if (rig.cameras.size() > kMaxCameras)
    throw Error("the rig has " + std::to_string(rig.cameras.size()) + " cameras; expected at most " +
                std::to_string(kMaxCameras));
  for (const Camera& camera : rig.cameras) {
    GpuCamera c = gpuCamera(camera, rig.workspace);
    c.row_words = (c.width + 63) / 64 * 2;
    c.mask_words = mask_words_;
    c.tile_entries = (c.width + kEntryPixels - 1) / kEntryPixels;
    c.first_entry = tile_entries_;
    c.image_words = image_words_;
    c.pixels_before = pixels_;
    image_words_ += (3 * c.width * c.height + 7) / 8 * 2;
    pixels_ += c.width * c.height;
    max_pixels_ = std::max(max_pixels_, c.width * c.height);
    mask_words_ += c.row_words * c.height;
    const std::uint32_t bands = (c.height + kLargeTilePixels - 1) / kLargeTilePixels;
    tile_entries_ += c.tile_entries * bands * kBandRows;
    max_bands_ = std::max(max_bands_, c.tile_entries * bands);
    max_rows_ = std::max(max_rows_, c.height);
    max_row_words_ = std::max(max_row_words_, c.row_words);
    host_cameras_.push_back(c);
  }
  cameras_ = Buffer<GpuCamera>(gpu, host_cameras_);
}

std::array<std::uint32_t, 2> GpuRig::sameSize() const {
  const GpuCamera& first = host_cameras_.front();
  for (const GpuCamera& camera : host_cameras_)
    if (camera.width != first.width || camera.height != first.height) return {0, 0};
  return {first.width, first.height};
}

std::uint32_t GpuRig::lensKinds() const {
  std::uint32_t kinds = 0;
  for (const GpuCamera& camera : host_cameras_) kinds |= 1u << camera.lens;
  return kinds;
}

void GpuRig::pack(const std::vector<Silhouette>& masks, std::span<std::uint32_t> words) const {
  std::fill(words.begin(), words.end(), 0u);
  for (std::size_t m = 0; m < masks.size(); ++m) {
    const GpuCamera& camera = host_cameras_[m];
    for (std::uint32_t y = 0; y < camera.height; ++y) {
      const std::uint8_t* row = masks[m].pixels.data() + std::size_t(y) * camera.width;
      std::uint32_t* packed = words.data() + camera.mask_words + y * camera.row_words;
      for (std::uint32_t x = 0; x < camera.width; ++x)
        packed[x / 32] |= std::uint32_t(row[x] >= Silhouette::kThreshold) << (x % 32);
    }
  }
}

std::vector<Silhouette> GpuRig::unpack(std::span<const std::uint32_t> words) const {
  std::vector<Silhouette> masks;
  for (const GpuCamera& camera : host_cameras_) {
    Silhouette mask{static_cast<int>(camera.width), static_cast<int>(camera.height), {}};
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
