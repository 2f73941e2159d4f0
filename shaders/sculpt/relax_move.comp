#version 460
// SPDX-License-Identifier: MIT
// How far a data point near the hand relaxes: its umbrella less the average of its neighbours'. See engine/sculpt/relax.h.
#extension GL_GOOGLE_include_directive : require
#include "shaders/sculpt/relax_io.h"
#include "shaders/core/invocation.glsl"
#include "shaders/core/quaternion.glsl"
#include "shaders/sculpt/symmetry.glsl"

layout(push_constant, scalar) uniform Push { RelaxMoveArgs args; };

#include "shaders/hand/hand_distance.glsl"
#include "shaders/sculpt/relax_frame.glsl"

// 1 on the skin and in the hand, 0 beyond the reach; for the nearest image of the hand.
float nearness(vec3 position) {
  float distance_m = args.reach_m;
  const uint images = imageCount(args.mirrors);
  for (uint image = 0; image < images; ++image) {
    const vec3 from_hand = mirrorOf(args.mirrors, image) * position - args.frame.at[0].position_now;
    distance_m = min(distance_m, distanceAt(rotate(conjugate(args.frame.at[0].rotation_now), from_hand)));
  }
  return 1 - smoothstep(0, args.reach_m, distance_m);
}

void main() {
  const uint index = invocation();
  if (index >= args.data_point_count) return;
  const float near = nearness(args.data_points.at[index]);
  vec3 displacement = vec3(0);
  if (near > 0) {
    const uint begin = args.starts.at[index], end = args.starts.at[index + 1];
    const bool border = args.borders.at[index] != 0;
    vec3 sum = vec3(0);
    uint count = 0;
    for (uint k = begin; k < end; ++k) {
      const uint neighbour = args.neighbours.at[k];
      // on a border, only the umbrellas of other border points count: those of a curve
      if (!border && args.borders.at[neighbour] != 0) continue;
      sum += args.umbrellas.at[neighbour];
      ++count;
    }
    if (count > 0) {
      const vec3 bilaplacian = args.umbrellas.at[index] - sum / count, normal = args.normals.at[index];
      displacement = bilaplacian.x * normal + bilaplacian.y * acrossBorder(index, normal);
    }
  }
  args.displacements.at[index] = args.strength * near * displacement;
}
