#version 460
// SPDX-License-Identifier: MIT
// Decides whether the frame's repeats continue, and how far the next pull goes. One workgroup; sums in a fixed order.
#extension GL_GOOGLE_include_directive : require
#include "shaders/sculpt/grip_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { GripCheckArgs args; };

#include "shaders/sculpt/contact_decide.glsl"

void main() {
  Findings found = Findings(0, 0, 0, 0);
  if (args.decision.frame.at[0].mode != kFrameIdle)
    for (uint i = gl_LocalInvocationID.x; i < args.data_point_count; i += gl_WorkGroupSize.x) {
      if (args.points.at[i].images == 0) continue;
      const GpuGripPoint point = args.points.at[i];
      found.achieved += point.achieved;
      found.pushed += dot(point.last_pull, point.last_pull);
      found.left_m = max(found.left_m, length(point.lag));
      ++found.touched;
    }
  decide(found);
}
