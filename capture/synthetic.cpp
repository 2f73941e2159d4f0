// SPDX-License-Identifier: MIT
#include "capture/synthetic.h"

#include <cmath>
#include <cstring>

#include "engine/hand_model.h"
#include "engine/sensor.h"

namespace airclay {
namespace {

constexpr double kDriftPeriodS = 7;

/// Upright, looking from `eye` at the origin.
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
  // no two opposite each other: their silhouettes would be mirror images
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

struct Synthetic::Parts {
  SyntheticOptions options;
  GpuRig rig;
  Sensor sensor;
  Recorder recorder;
  int frame_count = 0, background_frames = 0;
  std::optional<std::vector<TimedPose>> truth{std::in_place};

  Parts(Gpu& gpu, const SyntheticOptions& o)
      : options(o), rig(gpu, o.rig), sensor(gpu, rig, o.meshes), recorder(gpu) {}
};

Synthetic::Synthetic(Gpu& gpu, const SyntheticOptions& options)
    : parts_(std::make_unique<Parts>(gpu, options)) {
  parts_->frame_count = static_cast<int>(std::ceil(options.script.endS() * options.rate_hz)) + 1;
  for (int frame = 0; frame < parts_->frame_count; ++frame) {
    const auto pose = options.script.at(timeOf(frame));
    if (pose)
      parts_->truth->push_back({timeOf(frame), *pose});
    else
      ++parts_->background_frames;
  }
}

Synthetic::~Synthetic() = default;

const Rig& Synthetic::rig() const {
  return parts_->options.rig;
}
int Synthetic::frameCount() const {
  return parts_->frame_count;
}
double Synthetic::rateHz() const {
  return parts_->options.rate_hz;
}
double Synthetic::timeOf(int frame) const {
  return frame / parts_->options.rate_hz;
}
int Synthetic::backgroundFrames() const {
  return parts_->background_frames;
}
const std::optional<std::vector<TimedPose>>& Synthetic::truth() const {
  return parts_->truth;
}

bool Synthetic::readPictures(int frame, Buffers bgr) {
  if (frame >= parts_->frame_count) return false;
  if (bgr.size() != parts_->rig.cameraCount())
    throw std::logic_error("Synthetic: the buffers are not one a camera");
  const SyntheticOptions& options = parts_->options;
  SensorFrame sensor_frame;
  sensor_frame.seed = options.seed;
  sensor_frame.frame = static_cast<std::uint32_t>(frame);
  sensor_frame.noise_sigma = options.noise_sigma;
  sensor_frame.brightness = 1 + options.drift * std::sin(2 * M_PI * timeOf(frame) / kDriftPeriodS);
  parts_->recorder.begin();
  parts_->recorder.stage("sensor");
  parts_->sensor.record(parts_->recorder, options.script.at(timeOf(frame)), sensor_frame);
  parts_->recorder.submitAndWait();
  for (std::size_t camera = 0; camera < bgr.size(); ++camera) {
    const std::span<const std::uint8_t> picture = parts_->sensor.picture(camera);
    if (bgr[camera].size() != picture.size())
      throw std::logic_error("Synthetic: a buffer is not of its camera's size");
    std::memcpy(bgr[camera].data(), picture.data(), picture.size());
  }
  return true;
}

}  // namespace airclay
