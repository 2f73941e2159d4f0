#version 460
// SPDX-License-Identifier: MIT
// The hand grips a data point, or measures how far a gripped point lags behind. See engine/sculpt/grip.h.
#extension GL_GOOGLE_include_directive : require
#include "shaders/sculpt/grip_io.h"
#include "shaders/core/invocation.glsl"
#include "shaders/core/quaternion.glsl"
#include "shaders/sculpt/symmetry.glsl"

layout(push_constant, scalar) uniform Push { GripFindArgs args; };

#include "shaders/hand/hand_distance.glsl"

// Where the hand has carried a point that was gripped at `start`.
vec3 carried(GpuContactFrame frame, vec3 start) {
  const vec3 in_hand = rotate(conjugate(frame.rotation_gripped), start - frame.position_gripped);
  return rotate(frame.rotation_now, in_hand) + frame.position_now;
}

void main() {
  const uint index = invocation();
  if (index >= args.data_point_count) return;
  const GpuContactFrame frame = args.frame.at[0];
  const vec3 position = args.data_points.at[index];
  const uint images = imageCount(args.mirrors);
  if (frame.gripped == 0) {
    GpuGripPoint point = GpuGripPoint(position, 0, vec3(0), 0, vec3(0), vec3(0), vec3(0));
    for (uint image = 0; image < images; ++image) {
      const vec3 from_hand = mirrorOf(args.mirrors, image) * position - frame.position_now;
      if (distanceAt(rotate(conjugate(frame.rotation_now), from_hand)) <= args.reach_m) point.images |= 1u << image;
    }
    args.points.at[index] = point;
    return;
  }
  if (args.points.at[index].images == 0) return;
  GpuGripPoint point = args.points.at[index];
  Requests requests = noRequests();
  for (uint image = 0; image < images; ++image) {
    const vec3 mirror = mirrorOf(args.mirrors, image);
    if ((point.images >> image & 1) != 0) add(requests, mirror * carried(frame, mirror * point.start) - point.start);
  }
  const vec3 lag = point.start + combined(requests) - position;
  point.achieved = dot(point.last_pull, point.lag - lag);
  point.lag = lag;
  if (args.first != 0) {
    point.achieved = 0;
    point.pulled = vec3(0);
    point.pulled_plain = vec3(0);
    point.last_pull = vec3(0);
  }
  args.points.at[index] = point;
}
