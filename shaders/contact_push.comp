#version 460
// SPDX-License-Identifier: MIT
// The displacements that the solve is to bring about: of the points that are inside still, by the step that contact_check has chosen. Points are pushed, never pulled.
#extension GL_GOOGLE_include_directive : require
#include "shaders/contact_io.h"
#include "shaders/invocation.glsl"
#include "shaders/quaternion.glsl"

layout(push_constant, scalar) uniform Push { ContactPushArgs args; };

void main() {
  const uint index = invocation();
  if (index >= args.data_point_count) return;
  if (args.points.at[index].state != kPointReached) {
    args.displacements.at[index] = vec3(0);
    return;
  }
  GpuContactPoint point = args.points.at[index];
  float push = 0;
  if (point.depth > 0) {
    const float plain = point.pushed + args.frame.at[0].step * point.depth;
    push = plain + args.frame.at[0].momentum * (plain - point.pushed_plain) - point.pushed;
    point.pushed_plain = plain;
  } else {
    point.pushed_plain = point.pushed;
  }
  point.pushed += push;
  point.last_push = push;
  args.points.at[index] = point;
  args.displacements.at[index] =
      push != 0 ? push * rotate(args.frame.at[0].rotation_now, point.direction) : vec3(0);
}
