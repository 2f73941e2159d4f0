// SPDX-License-Identifier: MIT
// Hand poses in device memory: the root transform and the joint angles.
#ifndef AIRCLAY_HAND_POSE_IO_H
#define AIRCLAY_HAND_POSE_IO_H

#include "shaders/core/io.h"

AIRCLAY_IO_BEGIN

const uint kMaxHands = 2;
const uint kMaxHandJoints = 25;  // WebXR and OpenXR

// The root is the hand model's centre of gravity (the origin in the paper's fig. 3), with the axes of the
// hand frame.
struct GpuHandPose {
  vec4 rotation;                      // unit quaternion x y z w: workspace_from_hand
  vec3 position;                      // of the centre of gravity, workspace, metres
  uint tracked;                       // 1 if the pose is reliable
  vec3 joint_angles[kMaxHandJoints];  // rotation vectors from the rest pose, radians, in each joint's own
                                      // frame
};

READ_POINTER(ReadHandPoses, GpuHandPose)
WRITE_POINTER(WriteHandPoses, GpuHandPose)

AIRCLAY_IO_END

#endif
