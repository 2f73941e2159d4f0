#version 460
// SPDX-License-Identifier: MIT
// Normals at the data points: the area-weighted average of the adjacent quads' normals; zero where they cancel.
#extension GL_GOOGLE_include_directive : require
#include "shaders/clay/subdivide_io.h"
#include "shaders/core/invocation.glsl"

layout(push_constant, scalar) uniform Push { NormalsArgs args; };

void main() {
  const uint point = invocation();
  if (point >= args.data_point_count) return;
  vec3 sum = vec3(0);
  const uint end = args.quad_starts.at[point + 1];
  for (uint k = args.quad_starts.at[point]; k < end; ++k) {
    const uint quad = 4 * args.quads_at.at[k];
    const vec3 a = args.data_points.at[args.quads.at[quad]];
    const vec3 b = args.data_points.at[args.quads.at[quad + 1]];
    const vec3 c = args.data_points.at[args.quads.at[quad + 2]];
    const vec3 d = args.data_points.at[args.quads.at[quad + 3]];
    // twice the vector area
    sum += cross(c - a, d - b);
  }
  // scale before squaring: the square of a tiny quad's area would underflow
  const float largest = max(abs(sum.x), max(abs(sum.y), abs(sum.z)));
  args.normals.at[point] = largest > 0 ? normalize(sum / largest) : vec3(0);
}
