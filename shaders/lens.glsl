// SPDX-License-Identifier: MIT
// OpenCV's lens models (its calib3d manual) on the GPU; the CPU twin is engine/lens.cpp.

#include "shaders/camera_io.h"

struct Projection {
  vec2 pixel;
  bool valid;  // before the camera and within the lens model's monotonic range
};

// The distorted normalized position of `p` in camera coordinates. Undefined unless valid.
Projection distorted(GpuCamera camera, vec3 p) {
  Projection result;
  if (camera.lens == kLensFisheye) {
    const float r = length(p.xy);
    const float theta = atan(r, p.z);
    const float t2 = theta * theta;
    const float scale = 1 + t2 * (camera.distortion[0] + t2 * (camera.distortion[1] +
                            t2 * (camera.distortion[2] + t2 * camera.distortion[3])));
    // θ_d / r tends to 1 / z on the axis
    result.pixel = r > 1e-12 * p.z ? p.xy * (theta * scale / r) : p.xy / p.z;
    result.valid = p.z > 0 && theta <= camera.limit;
    return result;
  }
  const vec2 x = p.xy / p.z;
  result.pixel = x;
  result.valid = p.z > 0;
  if (camera.lens == kLensPinhole) return result;
  const float r2 = dot(x, x);
  const float radial = (1 + r2 * (camera.distortion[0] + r2 * (camera.distortion[1] + r2 * camera.distortion[4]))) /
                       (1 + r2 * (camera.distortion[5] + r2 * (camera.distortion[6] + r2 * camera.distortion[7])));
  const float p1 = camera.distortion[2], p2 = camera.distortion[3];
  result.pixel = x * radial + vec2(2 * p1 * x.x * x.y + p2 * (r2 + 2 * x.x * x.x),
                                   p1 * (r2 + 2 * x.y * x.y) + 2 * p2 * x.x * x.y);
  result.valid = result.valid && r2 <= camera.limit * camera.limit;
  return result;
}

// Where a point in camera coordinates falls, in pixels, inside the picture or not.
Projection projectThroughLens(GpuCamera camera, vec3 point_in_camera) {
  Projection result = distorted(camera, point_in_camera);
  result.pixel = camera.focal * result.pixel + camera.center;
  return result;
}
