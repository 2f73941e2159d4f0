#version 460
// SPDX-License-Identifier: MIT
// Target displacements for the solve: of the points that lag behind, by the step that grip_check has chosen.
#extension GL_GOOGLE_include_directive : require
#include "shaders/sculpt/grip_io.h"
#include "shaders/core/invocation.glsl"

layout(push_constant, scalar) uniform Push { GripPullArgs args; };

void main() {
  const uint index = invocation();
  if (index >= args.data_point_count) return;
  if (args.points.at[index].images == 0) {
    args.displacements.at[index] = vec3(0);
    return;
  }
  GpuGripPoint point = args.points.at[index];
  const vec3 plain = point.pulled + args.frame.at[0].step * point.lag;
  point.last_pull = plain + args.frame.at[0].momentum * (plain - point.pulled_plain) - point.pulled;
  point.pulled_plain = plain;
  point.pulled += point.last_pull;
  args.points.at[index] = point;
  args.displacements.at[index] = point.last_pull;
}
