// SPDX-License-Identifier: MIT
#include "engine/hand/hand_pose.h"

#include <algorithm>

namespace airclay {

GpuHandPose noHandPose() {
  GpuHandPose none;
  none.rotation.setZero();
  none.position.setZero();
  none.tracked = 0;
  for (vec3& angle : none.joint_angles) angle.setZero();
  return none;
}

GpuHandPose gpuHandPose(const HandPose& pose, const HandPoseFrame& frame) {
  GpuHandPose device = noHandPose();
  device.rotation = Eigen::Quaterniond(pose.world_from_hand.linear()).coeffs().cast<float>();
  device.position = (pose.world_from_hand * frame.center_of_mass - frame.workspace_center).cast<float>();
  device.tracked = 1;
  const std::size_t joints = std::min<std::size_t>(pose.joint_angles.size(), kMaxHandJoints);
  for (std::size_t j = 0; j < joints; ++j) device.joint_angles[j] = pose.joint_angles[j].cast<float>();
  return device;
}

HandPose handPose(const GpuHandPose& device, const HandPoseFrame& frame) {
  HandPose pose;
  Pose& root = pose.world_from_hand;
  root.linear() = rotationOf(device).toRotationMatrix();
  root.translation() =
      frame.workspace_center + device.position.cast<double>() - root.linear() * frame.center_of_mass;
  if (std::ranges::any_of(device.joint_angles, [](const vec3& angle) { return !angle.isZero(0); }))
    for (const vec3& angle : device.joint_angles) pose.joint_angles.push_back(angle.cast<double>());
  return pose;
}

}  // namespace airclay
