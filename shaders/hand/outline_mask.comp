#version 460
// SPDX-License-Identifier: MIT
// Draws a triangle of the skin into a camera's mask.
#extension GL_GOOGLE_include_directive : require
#include "shaders/camera/image_layout.glsl"
#include "shaders/hand/facing.glsl"
#include "shaders/hand/outline_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { OutlineMaskArgs args; };

void main() {
  if (gl_GlobalInvocationID.x >= args.triangle_count) return;
  const ImageLayout image = imageLayoutOf(args.cameras, gl_WorkGroupID.y);
  const GpuTriangle triangle = args.triangles.at[gl_GlobalInvocationID.x];
  vec2 p[3];
  for (uint k = 0; k < 3; ++k) p[k] = args.pixels.at[gl_WorkGroupID.y * args.vertex_count + triangle.corners[k]];
  if (min(p[0].x, min(p[1].x, p[2].x)) <= kNotProjected || !isFront(p[0], p[1], p[2])) return;
  const float top = min(p[0].y, min(p[1].y, p[2].y)), bottom = max(p[0].y, max(p[1].y, p[2].y));
  const int last = int(min(float(image.height) - 1, floor(bottom)));
  for (int y = int(max(0, ceil(top))); y <= last; ++y) {
    float low = 1e9, high = -1e9;
    for (uint k = 0; k < 3; ++k) {
      const vec2 a = p[k], b = p[(k + 1) % 3];
      if (min(a.y, b.y) > float(y) || max(a.y, b.y) < float(y)) continue;
      const float x = a.y == b.y ? b.x : mix(a.x, b.x, (float(y) - a.y) / (b.y - a.y));
      low = min(low, min(x, a.y == b.y ? a.x : x));
      high = max(high, max(x, a.y == b.y ? a.x : x));
    }
    const int first_x = int(max(0, ceil(low))), last_x = int(min(float(image.width) - 1, floor(high)));
    for (int word = first_x >> 5; word <= last_x >> 5 && first_x <= last_x; ++word) {
      uint bits = ~0u;
      if (word == first_x >> 5) bits &= ~0u << (first_x & 31);
      if (word == last_x >> 5) bits &= ~0u >> (31 - (last_x & 31));
      atomicOr(args.masks.at[image.mask_words + uint(y) * image.row_words + uint(word)], bits);
    }
  }
}
