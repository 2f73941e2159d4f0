// SPDX-License-Identifier: MIT
// Silhouettes of the built-in hand: the result of a perfect segmentation.
#pragma once

#include "engine/synthetic/demo_scene.h"
#include "engine/synthetic/sensor.h"

namespace airclay {

/// Renders meshes in a hand pose for the cameras of a rig.
class HandCameras {
 public:
  explicit HandCameras(const Rig& rig = demoRig(), const std::vector<TriangleMesh>& meshes = demoArm());

  /// The pixels that are at least half covered, one mask per camera.
  std::vector<Silhouette> masks(const Pose& world_from_hand);
  const GpuRig& rig() const { return rig_; }

 private:
  GpuRig rig_;
  Sensor sensor_;
  Recorder recorder_;
};

/// The rig in a world rotated about its origin: the point p becomes turn * p, and the images stay the same.
/// \pre the workspace's centre is the origin
Rig turned(const Rig& rig, const Eigen::Quaterniond& turn);

/// The distance of a pose from the true one: metres at the hand's centre of gravity, and degrees.
struct PoseError {
  double shift_m = 0, turn_degrees = 0;
};
PoseError poseError(const Pose& found, const Pose& truth, const Vec3& center_of_mass_in_hand);

}  // namespace airclay
