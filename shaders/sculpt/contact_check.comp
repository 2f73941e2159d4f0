#version 460
// SPDX-License-Identifier: MIT
// Decides whether the frame's repeats continue, and how far the next push goes. One workgroup; sums in a fixed order.
#extension GL_GOOGLE_include_directive : require
#include "shaders/sculpt/contact_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { ContactCheckArgs args; };

#include "shaders/sculpt/contact_decide.glsl"

void main() {
  Findings found = Findings(0, 0, 0, 0);
  if (args.decision.frame.at[0].mode == kFrameSweep)
    for (uint i = gl_LocalInvocationID.x; i < args.point_count; i += gl_WorkGroupSize.x) {
      if (args.points.at[i].state != kPointReached) continue;
      const GpuContactPoint point = args.points.at[i];
      found.achieved += point.last_push * (point.depth_before - point.depth);
      found.pushed += point.last_push * point.last_push;
      found.left_m = max(found.left_m, point.depth);
      ++found.touched;
    }
  decide(found);
}
