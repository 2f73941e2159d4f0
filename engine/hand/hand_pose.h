// SPDX-License-Identifier: MIT
// The pose of a hand: root transform and joint angles.
#pragma once

#include <vector>

#include "engine/core/math.h"
#include "shaders/hand/hand_pose_io.h"

namespace airclay {

struct HandPose {
  Pose world_from_hand = Pose::Identity();  ///< the root: the hand model's frame in the world, metres
  /// Rotation vectors from the rest pose, radians, one per joint of the hand model, in the joint's own frame
  /// (posedSkin()). Empty: the rest pose, straight fingers.
  std::vector<Vec3> joint_angles;
};

/// The rotation of a pose in device memory, normalized.
inline Eigen::Quaterniond rotationOf(const GpuHandPose& pose) {
  return Eigen::Quaterniond(Eigen::Vector4d(pose.rotation.cast<double>())).normalized();
}

/// The reference points of poses in device memory.
struct HandPoseFrame {
  Vec3 center_of_mass = Vec3::Zero();    ///< of the hand model, hand frame, metres
  Vec3 workspace_center = Vec3::Zero();  ///< world, metres
};

/// A pose of all zeros, not tracked: no hand. (Eigen does not initialize vectors.)
GpuHandPose noHandPose();

/// The pose for the kernels, marked as tracked. \pre at most kMaxHandJoints joint angles
GpuHandPose gpuHandPose(const HandPose& pose, const HandPoseFrame& frame);
/// The inverse of gpuHandPose(). Joint angles that are all zero become the rest pose (empty).
HandPose handPose(const GpuHandPose& pose, const HandPoseFrame& frame);

}  // namespace airclay
