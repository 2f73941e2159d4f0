#version 460
// SPDX-License-Identifier: MIT
// Decides whether there is anything to relax, and counts the repeats. One workgroup.
#extension GL_GOOGLE_include_directive : require
#include "shaders/sculpt/relax_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { RelaxCheckArgs args; };

#include "shaders/sculpt/contact_decide.glsl"

void main() {
  Findings found = Findings(0, 0, 0, 0);
  if (args.decision.frame.at[0].mode == kFrameSweep)
    for (uint i = gl_LocalInvocationID.x; i < args.data_point_count; i += gl_WorkGroupSize.x) {
      const vec3 displacement = args.displacements.at[i];
      if (displacement == vec3(0)) continue;
      found.left_m = max(found.left_m, length(displacement));
      ++found.touched;
    }
  decide(found);
}
