#version 460
// SPDX-License-Identifier: MIT
// (5) d = A p: the whole subdivision as one sparse matrix, one invocation per row.
#extension GL_GOOGLE_include_directive : require
#include "shaders/clay/subdivide_io.h"
#include "shaders/core/invocation.glsl"

layout(push_constant, scalar) uniform Push { SubdivideArgs args; };

void main() {
  const uint point = invocation();
  if (point >= args.data_point_count) return;
  vec3 sum = vec3(0);
  const uint end = args.row_starts.at[point + 1];
  for (uint k = args.row_starts.at[point]; k < end; ++k)
    sum += args.weights.at[k] * args.control_points.at[args.columns.at[k]];
  args.data_points.at[point] = sum;
}
