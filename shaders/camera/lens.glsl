// SPDX-License-Identifier: MIT
// OpenCV's lens models (its calib3d manual) on the GPU; the CPU twin is engine/camera/lens.cpp.
//
// kLenses, a specialization constant of the including shader, has one bit per lens kind that the rig uses: software devices execute both
// sides of a branch, so code for unused lens kinds must be compiled out.

#include "shaders/camera/camera_io.h"

bool rigHas(uint lens) { return (kLenses >> lens & 1u) != 0; }

struct Projection {
  vec2 pixel;
  bool valid;  // in front of the camera and within the lens model's monotonic range
};

Projection projectFisheye(GpuCamera camera, vec3 p) {
  const float r = length(p.xy);
  const float theta = atan(r, p.z);
  const float t2 = theta * theta;
  const float scale = 1 + t2 * (camera.distortion[0] + t2 * (camera.distortion[1] +
                          t2 * (camera.distortion[2] + t2 * camera.distortion[3])));
  // θ_d / r tends to 1 / z on the axis
  const vec2 x = r > 1e-12 * p.z ? p.xy * (theta * scale / r) : p.xy / p.z;
  return Projection(camera.focal * x + camera.center, p.z > 0 && theta <= camera.limit);
}

Projection projectPerspective(GpuCamera camera, vec3 p) {
  vec2 x = p.xy * (1 / p.z);
  bool valid = p.z > 0;
  if (rigHas(kLensPerspective) || rigHas(kLensRational)) {  // a pinhole has zero coefficients, so the polynomials are the identity
    const float r2 = dot(x, x);
    float radial = 1 + r2 * (camera.distortion[0] + r2 * (camera.distortion[1] + r2 * camera.distortion[4]));
    if (rigHas(kLensRational))
      radial /= 1 + r2 * (camera.distortion[5] + r2 * (camera.distortion[6] + r2 * camera.distortion[7]));
    const float p1 = camera.distortion[2], p2 = camera.distortion[3];
    const float twice_xy = 2 * x.x * x.y;
    const vec2 tangential = vec2(p1 * twice_xy + p2 * (r2 + 2 * x.x * x.x), p1 * (r2 + 2 * x.y * x.y) + p2 * twice_xy);
    valid = valid && r2 <= camera.limit * camera.limit;
    x = x * radial + tangential;
  }
  return Projection(camera.focal * x + camera.center, valid);
}

// Where a point in camera coordinates projects to, in pixels, possibly outside the image. The pixel is undefined unless valid.
Projection projectThroughLens(GpuCamera camera, vec3 point_in_camera) {
  if (!rigHas(kLensFisheye)) return projectPerspective(camera, point_in_camera);
  if (kLenses == 1u << kLensFisheye || camera.lens == kLensFisheye) return projectFisheye(camera, point_in_camera);
  return projectPerspective(camera, point_in_camera);
}
