#version 460
// SPDX-License-Identifier: MIT
// Selects the mode of this frame. A sweep requires that the hand was tracked and the clutch held in the last frame too.
#extension GL_GOOGLE_include_directive : require
#include "shaders/sculpt/contact_io.h"
#include "shaders/core/quaternion.glsl"

layout(local_size_x = 1) in;
layout(push_constant, scalar) uniform Push { ContactBeginArgs args; };

void main() {
  const vec4 rotation = multiply(args.clay_from_workspace, args.hand.at[0].rotation);
  const vec3 position = rotate(args.clay_from_workspace, args.hand.at[0].position);
  GpuContactFrame frame = args.frame.at[0];
  const bool known = frame.known != 0 && args.forget == 0;
  const bool now = args.hand.at[0].tracked != 0 && args.held != 0;
  frame.mode = !now ? kFrameIdle : known ? kFrameSweep : kFrameStart;
  frame.known = now ? 1 : 0;
  frame.rotation_before = frame.mode == kFrameSweep ? frame.rotation_now : rotation;
  frame.position_before = frame.mode == kFrameSweep ? frame.position_now : position;
  // q and -q are the same rotation: choose the shorter path
  frame.rotation_now = dot(frame.rotation_before, rotation) < 0 ? -rotation : rotation;
  frame.position_now = position;
  if (frame.mode != kFrameSweep) frame.gripped = 0;
  if (frame.gripped == 0) {
    frame.rotation_gripped = frame.rotation_now;
    frame.position_gripped = frame.position_now;
  }
  frame.done = 0;
  frame.touched = 0;
  frame.repeats = 0;
  frame.stalls = 0;
  frame.depth_m = 0;
  frame.least_m = 0;
  frame.quotient = 0;
  frame.step = 1;
  frame.momentum = 0;
  frame.theta = 1;
  frame.find_groups = now ? GpuGroups(args.groups.points_x, args.groups.points_y, args.groups.images) : GpuGroups(0, 1, 1);
  frame.point_groups = GpuGroups(0, 1, 1);
  frame.project_groups = GpuGroups(0, 1, 1);
  frame.apply_groups = GpuGroups(0, 1, 1);
  frame.check_groups = GpuGroups(1, 1, 1);
  frame.normal_groups = GpuGroups(0, 1, 1);
  args.frame.at[0] = frame;
}
