#version 460
// SPDX-License-Identifier: MIT
// The umbrella operator: from a data point to the average of its neighbours on the surface.
#extension GL_GOOGLE_include_directive : require
#include "shaders/relax_io.h"
#include "shaders/invocation.glsl"

layout(push_constant, scalar) uniform Push { RelaxUmbrellaArgs args; };

void main() {
  const uint index = invocation();
  if (index >= args.data_point_count) return;
  const uint begin = args.starts.at[index], end = args.starts.at[index + 1];
  const vec3 position = args.data_points.at[index];
  vec3 sum = vec3(0);
  for (uint k = begin; k < end; ++k) sum += args.data_points.at[args.neighbours.at[k]] - position;
  args.umbrellas.at[index] = sum / max(end - begin, 1);
}
