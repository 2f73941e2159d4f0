#version 460
// SPDX-License-Identifier: MIT
// (6) in displacements, p += (AᵀA)⁺ (Aᵀ r): one invocation per control point.
#extension GL_GOOGLE_include_directive : require
#include "shaders/clay/solve_io.h"
#include "shaders/core/invocation.glsl"

layout(push_constant, scalar) uniform Push { SolveApplyArgs args; };

void main() {
  const uint point = invocation();
  const uint count = args.control_point_count;
  if (point >= count) return;
  dvec3 moved = dvec3(0);
  for (uint j = 0; j < count; ++j) {
    // symmetric: read down the column, so that neighbouring invocations read adjacent numbers
    const double weight = args.gram_inverse.at[j * count + point];
    moved += weight * dvec3(args.projected.at[3 * j], args.projected.at[3 * j + 1], args.projected.at[3 * j + 2]);
  }
  vec3 rounded;
  for (uint axis = 0; axis < 3; ++axis) {
    const double position = args.exact_points.at[3 * point + axis] + moved[axis];
    args.exact_points.at[3 * point + axis] = position;
    rounded[axis] = float(position);
  }
  args.control_points.at[point] = rounded;
}
