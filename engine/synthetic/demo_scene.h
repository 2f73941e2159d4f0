// SPDX-License-Identifier: MIT
// The demo's cameras and what they see: realistic data without a recording, for `airclay demo`, `compare` and
// `bench`.
#pragma once

#include "engine/synthetic/script.h"
#include "engine/synthetic/sensor.h"

namespace airclay {

/// Four cameras of 640 x 480 about 1.1 m from the 60 cm cube, at different heights and all round it, every
/// one seeing all of the cube, with the mild lens distortion of webcams.
Rig demoRig();

/// The built-in right hand and its forearm, as the cameras see them. Hand frame, metres.
std::vector<TriangleMesh> demoArm();

inline constexpr double kDemoRateHz = 30;

/// The scripted hand before the demo's cameras, drawn frame by frame.
class DemoCameras {
 public:
  /// `rig` must outlive this.
  DemoCameras(Gpu& gpu, const GpuRig& rig);

  /// The true world_from_hand; none before the hand appears.
  std::optional<Pose> pose(int frame) const { return script_.at(frame / kDemoRateHz); }
  int backgroundFrames() const { return background_frames_; }  ///< those before the hand appears
  int frameCount() const { return frame_count_; }

  /// One frame's images in GpuRig's layout, valid until the next call. The same frame has the same bytes.
  const Buffer<std::uint32_t>& draw(int frame);
  /// What draw() drew last.
  const Buffer<std::uint32_t>& images() const { return sensor_.images(); }

 private:
  HandScript script_ = demoScript();
  Sensor sensor_;
  Recorder recorder_;
  int frame_count_ = 0, background_frames_ = 0;
};

}  // namespace airclay
