#version 460
// SPDX-License-Identifier: MIT
// Distributes a triangle's area over sample points on it, and adds it to the cells that contain them.
#extension GL_GOOGLE_include_directive : require
#include "shaders/render/renderer_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { RenderDensityArgs args; };

const uint kMostSteps = 24;  // along an edge; a larger triangle is sampled sparsely

vec3 corner(uint index) {
  const vec3 place = args.rotation * args.positions.at[args.triangles.at[index]] + args.translation;
  return (place / args.edge_m + 0.5) * kDensityCells;
}

void main() {
  const uint triangle = gl_GlobalInvocationID.x;
  if (triangle >= args.triangle_count) return;
  const vec3 a = corner(3 * triangle), b = corner(3 * triangle + 1), c = corner(3 * triangle + 2);
  const float area = 0.5 * length(cross(b - a, c - a));  // in faces of the finest cells
  const float longest = max(length(b - a), max(length(c - a), length(c - b)));
  const uint steps = clamp(uint(ceil(2 * longest)), 1, kMostSteps);
  // steps² equal small triangles, each with its centroid: upright ones and the ones between them; more than a face or two per cell does not
  // matter and would overflow
  const uint share = uint(min(args.weight * area / (steps * steps), 64.0) * kDensityUnit);
  for (uint i = 0; i < steps; ++i)
    for (uint j = 0; j < 2 * (steps - i) - 1; ++j) {
      const float third = (j & 1u) == 0 ? 1.0 / 3 : 2.0 / 3;
      const vec2 at = (vec2(i, j / 2) + third) / steps;
      const ivec3 cell = ivec3(floor(a + at.x * (b - a) + at.y * (c - a)));
      if (any(lessThan(cell, ivec3(0))) || any(greaterThanEqual(cell, ivec3(kDensityCells)))) continue;
      atomicAdd(args.areas.at[cell.x + kDensityCells * (cell.y + kDensityCells * cell.z)], share);
    }
}
