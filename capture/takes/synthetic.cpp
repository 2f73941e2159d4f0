// SPDX-License-Identifier: MIT
#include "capture/takes/synthetic.h"

#include <cmath>
#include <cstring>

#include "engine/synthetic/sensor.h"

namespace airclay {
namespace {

constexpr double kDriftPeriodS = 7;

}  // namespace

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
  parts_->frame_count = static_cast<int>(std::ceil(options.script.endSeconds() * options.rate_hz)) + 1;
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

bool Synthetic::readImages(int frame, Buffers bgr) {
  if (frame >= parts_->frame_count) return false;
  if (bgr.size() != parts_->rig.cameraCount())
    throw std::logic_error("Synthetic: expected one buffer per camera");
  const SyntheticOptions& options = parts_->options;
  SensorFrame sensor_frame;
  sensor_frame.seed = options.seed;
  sensor_frame.frame = static_cast<std::uint32_t>(frame);
  sensor_frame.noise_sigma = options.noise_sigma;
  sensor_frame.brightness = 1 + options.drift * std::sin(2 * M_PI * timeOf(frame) / kDriftPeriodS);
  parts_->sensor.draw(parts_->recorder, options.script.at(timeOf(frame)), sensor_frame);
  for (std::size_t camera = 0; camera < bgr.size(); ++camera) {
    const std::span<const std::uint8_t> image = parts_->sensor.image(camera);
    if (bgr[camera].size() != image.size())
      throw std::logic_error("Synthetic: a buffer does not have its camera's size");
    std::memcpy(bgr[camera].data(), image.data(), image.size());
  }
  return true;
}

}  // namespace airclay
