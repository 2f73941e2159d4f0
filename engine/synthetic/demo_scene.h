// SPDX-License-Identifier: MIT
// The demo's cameras and their images: realistic data without a recording, for `airclay demo`, `compare` and
// `bench`.
#pragma once

#include "engine/synthetic/script.h"
#include "engine/synthetic/sensor.h"

namespace airclay {

/// Four cameras of 640 x 480 pixels around the 60 cm cube, about 1.2 m from its centre and at different
/// heights. Each sees the whole cube, with the mild lens distortion of webcams.
Rig demoRig();

/// The built-in right hand and its forearm. Hand frame, metres.
std::vector<TriangleMesh> demoArm();

inline constexpr double kDemoRateHz = 30;

/// Draws the scripted hand in the demo's cameras, frame by frame.
class DemoCameras {
 public:
  /// `rig` must outlive this.
  DemoCameras(Gpu& gpu, const GpuRig& rig);

  /// The true world_from_hand; empty before the hand appears.
  std::optional<Pose> pose(int frame) const { return script_.at(frame / kDemoRateHz); }
  int backgroundFrames() const { return background_frames_; }  ///< frames before the hand appears
  int frameCount() const { return frame_count_; }

  /// One frame's images in GpuRig's layout, valid until the next call. The same frame has the same bytes.
  const Buffer<std::uint32_t>& draw(int frame);
  /// The images of the last draw().
  const Buffer<std::uint32_t>& images() const { return sensor_.images(); }

 private:
  HandScript script_ = demoScript();
  Sensor sensor_;
  Recorder recorder_;
  int frame_count_ = 0, background_frames_ = 0;
};

}  // namespace airclay
