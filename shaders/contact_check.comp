#version 460
// SPDX-License-Identifier: MIT
// Whether the frame's repeats go on, and how far the next push goes. One workgroup; sums in a fixed order.
//
// A push of the reached points by x along their directions moves them by Q x, Q = E A A⁺ Eᵀ (E takes displacements along the directions), symmetric with
// eigenvalues between 0 and 1, mostly far below 1: the cage spreads what few points want over all. The largest Rayleigh quotient of Q met in this frame, from the
// pushes done and what they achieved, stands for its largest eigenvalue L, and 1 / L is the step of gradient descent.
// On top of it Nesterov's momentum (1983), as in Mazhar et al. 2015, "Using Nesterov's method to accelerate multibody dynamics with friction and contact".
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "shaders/contact_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { ContactCheckArgs args; };

shared float achieved_of[32], pushed_of[32], depth_of[32];  // at most 32 subgroups
shared uint touched_of[32];

void decide(float achieved, float pushed, float depth_m, uint touched) {
  GpuContactFrame frame = args.frame.at[0];
  frame.touched = touched;
  frame.depth_m = depth_m;
  if (pushed > 0) frame.quotient = max(frame.quotient, clamp(achieved / pushed, kContactMinQuotient, 1));
  if (frame.repeats == 0 || depth_m < kContactShrinks * frame.least_m) {
    frame.least_m = depth_m;
    frame.stalls = 0;
  } else {
    ++frame.stalls;
  }
  const bool done =
      frame.mode != kFrameSweep || depth_m < kContactDepthWanted || frame.stalls == kContactMaxStalls || frame.repeats == kContactMaxRepeats;
  frame.done = done ? 1 : 0;
  frame.step = frame.quotient > 0 ? 1 / frame.quotient : 1;
  frame.momentum = 0;
  if (frame.repeats >= 2) {  // the first step knows no quotient, the second is the first of its size
    const float next = 0.5 * (1 + sqrt(1 + 4 * frame.theta * frame.theta));
    frame.momentum = (frame.theta - 1) / next;
    frame.theta = next;
  }
  if (!done) ++frame.repeats;
  frame.point_groups = GpuGroups(done ? 0 : args.groups.points_x, args.groups.points_y, 1);
  frame.project_groups = GpuGroups(done ? 0 : args.groups.project, 1, 1);
  frame.apply_groups = GpuGroups(done ? 0 : args.groups.apply, 1, 1);
  frame.check_groups = GpuGroups(done ? 0 : 1, 1, 1);
  frame.normal_groups = GpuGroups(done && frame.repeats > 0 ? args.groups.points_x : 0, args.groups.points_y, 1);
  args.frame.at[0] = frame;
  args.summary.at[0] = GpuContactSummary(touched, frame.repeats, depth_m, frame.done);
}

void main() {
  float achieved = 0, pushed = 0, depth_m = 0;
  uint touched = 0;
  if (args.frame.at[0].mode == kFrameSweep)
    for (uint i = gl_LocalInvocationID.x; i < args.data_point_count; i += gl_WorkGroupSize.x) {
      if (args.points.at[i].state != kPointReached) continue;
      const GpuContactPoint point = args.points.at[i];
      achieved += point.last_push * (point.depth_before - point.depth);
      pushed += point.last_push * point.last_push;
      depth_m = max(depth_m, point.depth);
      ++touched;
    }
  achieved = subgroupAdd(achieved);
  pushed = subgroupAdd(pushed);
  depth_m = subgroupMax(depth_m);
  touched = subgroupAdd(touched);
  if (gl_NumSubgroups > 1) {
    if (subgroupElect()) {
      achieved_of[gl_SubgroupID] = achieved;
      pushed_of[gl_SubgroupID] = pushed;
      depth_of[gl_SubgroupID] = depth_m;
      touched_of[gl_SubgroupID] = touched;
    }
    barrier();
    if (gl_LocalInvocationID.x == 0)
      for (uint i = 1; i < gl_NumSubgroups; ++i) {
        achieved += achieved_of[i];
        pushed += pushed_of[i];
        depth_m = max(depth_m, depth_of[i]);
        touched += touched_of[i];
      }
  }
  if (gl_LocalInvocationID.x == 0) decide(achieved, pushed, depth_m, touched);
}
