// SPDX-License-Identifier: MIT
#include "tests/support/scene.h"

#include <cmath>

namespace airclay {

Rig ringRig(int count, int width, int height) {
  Rig rig;
  for (int i = 0; i < count; ++i) {
    Camera camera;
    camera.name = "cam" + std::to_string(i);
    camera.width = width;
    camera.height = height;
    camera.lens.fx = camera.lens.fy = 0.9 * width;
    camera.lens.cx = 0.5 * width - 0.5 + 2.3;
    camera.lens.cy = 0.5 * height - 0.5 - 1.7;
    camera.lens.distortion = {-0.11, 0.03, 1e-4, -2e-4, 0.001, 0, 0, 0};
    camera.lens = withMonotonicRange(camera.lens);
    const double angle = 2 * M_PI * i / count + 0.3, height_m = i % 2 ? 0.75 : 0.35;
    const Vec3 eye(std::cos(angle), std::sin(angle), height_m);
    const Vec3 forward = -eye.normalized();
    const Vec3 right = forward.cross(Vec3::UnitZ()).normalized();
    Mat3 world_from_camera;
    world_from_camera << right, forward.cross(right), forward;
    Pose pose = Pose::Identity();
    pose.linear() = world_from_camera;
    pose.translation() = eye;
    camera.camera_from_world = pose.inverse();
    rig.cameras.push_back(camera);
  }
  return rig;
}

std::vector<Silhouette> sphereMasks(const Rig& rig, const Vec3& center, double radius_m) {
  std::vector<Silhouette> masks;
  for (const Camera& camera : rig.cameras) {
    Silhouette mask{camera.width, camera.height,
                    std::vector<std::uint8_t>(std::size_t(camera.width) * camera.height)};
    const Vec3 center_in_camera = camera.camera_from_world * center;
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x)
        if (const auto ray = rayThroughPixel(camera.lens, Vec2(x, y)))
          if (ray->cross(center_in_camera).norm() <= radius_m && ray->dot(center_in_camera) > 0)
            mask.pixels[std::size_t(y) * camera.width + x] = 255;
    masks.push_back(std::move(mask));
  }
  return masks;
}

}  // namespace airclay
