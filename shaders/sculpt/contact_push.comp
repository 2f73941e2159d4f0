#version 460
// SPDX-License-Identifier: MIT
// Target displacements for the solve: of the points that are still inside, by the step that contact_check has chosen. Points are pushed,
// never pulled.
#extension GL_GOOGLE_include_directive : require
#include "shaders/sculpt/contact_io.h"
#include "shaders/core/invocation.glsl"
#include "shaders/core/quaternion.glsl"
#include "shaders/sculpt/symmetry.glsl"

layout(push_constant, scalar) uniform Push { ContactPushArgs args; };

// Updates the point's totals, and returns its push in this repeat.
vec3 push(inout GpuContactPoint point) {
  float push_m = 0;
  if (point.depth > 0) {
    const float plain = point.pushed + args.frame.at[0].step * point.depth;
    push_m = plain + args.frame.at[0].momentum * (plain - point.pushed_plain) - point.pushed;
    point.pushed_plain = plain;
  } else {
    point.pushed_plain = point.pushed;
  }
  point.pushed += push_m;
  point.last_push = push_m;
  return push_m != 0 ? push_m * rotate(args.frame.at[0].rotation_now, point.direction) : vec3(0);
}

void main() {
  const uint data_point = invocation();
  if (data_point >= args.data_point_count) return;
  Requests requests = noRequests();
  const uint images = imageCount(args.mirrors);
  for (uint image = 0; image < images; ++image) {
    const uint index = image * args.data_point_count + data_point;
    if (args.points.at[index].state != kPointReached) continue;
    GpuContactPoint point = args.points.at[index];
    add(requests, mirrorOf(args.mirrors, image) * push(point));
    args.points.at[index] = point;
  }
  args.displacements.at[data_point] = combined(requests);
}
