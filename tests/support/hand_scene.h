// SPDX-License-Identifier: MIT
// The built-in hand before cameras, as silhouettes: what a perfect segmentation would give.
#pragma once

#include "engine/synthetic/demo_scene.h"
#include "engine/synthetic/sensor.h"

namespace airclay {

/// Draws meshes that move with the hand before the cameras of a rig.
class HandCameras {
 public:
  explicit HandCameras(const Rig& rig = demoRig(), const std::vector<TriangleMesh>& meshes = demoArm());

  /// The pixels that the meshes cover to half, one mask a camera.
  std::vector<Mask> masks(const Pose& world_from_hand);
  const GpuRig& rig() const { return rig_; }

 private:
  GpuRig rig_;
  Sensor sensor_;
  Recorder recorder_;
};

/// The rig seen from a world turned about its origin: what was at p is at turn * p, and the images stay.
/// \pre the workspace's centre is the origin
Rig turned(const Rig& rig, const Eigen::Quaterniond& turn);

/// How far a pose is from the true one: metres at the hand's centre of gravity, and degrees.
struct PoseError {
  double shift_m = 0, turn_degrees = 0;
};
PoseError poseError(const Pose& found, const Pose& truth, const Vec3& center_of_mass_in_hand);

}  // namespace airclay
