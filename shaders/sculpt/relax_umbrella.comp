#version 460
// SPDX-License-Identifier: MIT
// The umbrella operator: from a data point to the average of its neighbours on the surface, along its normal and across its border.
#extension GL_GOOGLE_include_directive : require
#include "shaders/sculpt/relax_io.h"
#include "shaders/core/invocation.glsl"

layout(push_constant, scalar) uniform Push { RelaxUmbrellaArgs args; };

#include "shaders/sculpt/relax_frame.glsl"

void main() {
  const uint index = invocation();
  if (index >= args.data_point_count) return;
  const uint begin = args.starts.at[index], end = args.starts.at[index + 1];
  const vec3 position = args.data_points.at[index], normal = args.normals.at[index];
  vec3 sum = vec3(0);
  for (uint k = begin; k < end; ++k) sum += args.data_points.at[args.neighbours.at[k]] - position;
  const vec3 umbrella = sum / max(end - begin, 1);
  args.umbrellas.at[index] = vec3(dot(umbrella, normal), dot(umbrella, acrossBorder(index, normal)), 0);
}
