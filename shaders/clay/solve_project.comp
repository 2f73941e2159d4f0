#version 460
// SPDX-License-Identifier: MIT
// Aᵀ r in double precision, r the data points' displacements: one workgroup per control point, summed in a fixed order.
#extension GL_GOOGLE_include_directive : require
#include "shaders/clay/solve_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { SolveProjectArgs args; };

shared dvec3 sums[gl_WorkGroupSize.x];

void main() {
  const uint column = gl_WorkGroupID.x;
  const uint end = args.column_starts.at[column + 1];
  dvec3 sum = dvec3(0);
  for (uint k = args.column_starts.at[column] + gl_LocalInvocationID.x; k < end; k += gl_WorkGroupSize.x) {
    const vec3 displacement = args.displacements.at[args.rows.at[k]];
    // most data points do not move
    if (displacement != vec3(0)) sum += double(args.weights.at[k]) * dvec3(displacement);
  }
  sums[gl_LocalInvocationID.x] = sum;
  barrier();
  if (gl_LocalInvocationID.x != 0) return;
  for (uint i = 1; i < gl_WorkGroupSize.x; ++i) sum += sums[i];
  for (uint axis = 0; axis < 3; ++axis) args.projected.at[3 * column + axis] = sum[axis];
}
