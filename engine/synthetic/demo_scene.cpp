// SPDX-License-Identifier: MIT
#include "engine/synthetic/demo_scene.h"

#include <cmath>

#include "engine/hand/hand_model.h"

namespace airclay {
namespace {

/// camera_from_world of an upright camera at `eye` that looks at the origin.
Pose cameraLookingFrom(const Vec3& eye) {
  const Vec3 forward = -eye.normalized();
  const Vec3 right = forward.cross(Vec3::UnitZ()).normalized();
  Pose world_from_camera = Pose::Identity();
  world_from_camera.linear() << right, forward.cross(right), forward;
  world_from_camera.translation() = eye;
  return world_from_camera.inverse();
}

}  // namespace

Rig demoRig() {
  struct Place {
    const char* name;
    double azimuth_degrees, distance_m, height_m, focal_pixels, k1, k2;
  };
  // no two cameras are opposite each other: their silhouettes would be mirror images
  const Place places[] = {{"left", 155, 1.18, 0.45, 452, -0.105, 0.032},
                          {"front", 248, 1.22, 0.80, 461, -0.096, 0.027},
                          {"right", 338, 1.16, 0.30, 447, -0.112, 0.036},
                          {"back", 62, 1.24, 0.95, 465, -0.090, 0.024}};
  Rig rig;
  for (const Place& place : places) {
    Camera camera;
    camera.name = place.name;
    camera.width = 640;
    camera.height = 480;
    camera.lens.fx = place.focal_pixels;
    camera.lens.fy = 1.002 * place.focal_pixels;
    camera.lens.cx = 319.5 + 0.02 * (place.azimuth_degrees - 200);
    camera.lens.cy = 239.5 + 4 * (place.height_m - 0.6);
    camera.lens.distortion = {place.k1, place.k2, 4e-4, -3e-4, 0, 0, 0, 0};
    camera.lens = withMonotonicRange(camera.lens);
    const double azimuth = place.azimuth_degrees * M_PI / 180;
    const double across = std::sqrt(place.distance_m * place.distance_m - place.height_m * place.height_m);
    camera.camera_from_world =
        cameraLookingFrom(Vec3(across * std::cos(azimuth), across * std::sin(azimuth), place.height_m));
    rig.cameras.push_back(camera);
  }
  return rig;
}

std::vector<TriangleMesh> demoArm() {
  return {builtInHand(false).skin, builtInForearm(false)};
}

DemoCameras::DemoCameras(Gpu& gpu, const GpuRig& rig) : sensor_(gpu, rig, demoArm()), recorder_(gpu) {
  frame_count_ = static_cast<int>(std::ceil(script_.endSeconds() * kDemoRateHz)) + 1;
  while (background_frames_ < frame_count_ && !pose(background_frames_)) ++background_frames_;
}

const Buffer<std::uint32_t>& DemoCameras::draw(int frame) {
  SensorFrame sensor_frame;
  sensor_frame.frame = static_cast<std::uint32_t>(frame);
  sensor_.draw(recorder_, pose(frame), sensor_frame);
  return sensor_.images();
}

}  // namespace airclay
