#version 460
// SPDX-License-Identifier: MIT
// A quad around a segment or a dot, facing the eye.
#extension GL_GOOGLE_include_directive : require
#include "shaders/render/renderer_io.h"

layout(constant_id = 0) const uint kDots = 0;
layout(push_constant, scalar) uniform Push { RenderStrokeArgs args; };
layout(location = 0) noperspective out vec2 along_across;  // pixels, from the segment's start
layout(location = 1) flat out float segment_length;        // pixels

vec4 clipPoint(uint index) {
  const uint at = uint64_t(args.indices) != 0 ? args.indices.at[index] : index;
  const vec3 place = mix(args.points.at[at], args.eye, kStrokeNearer);
  return args.clip_from_strokes * vec4(place, 1);
}

void main() {
  const uint quad = gl_VertexIndex / 6, corner = gl_VertexIndex % 6;
  vec4 a = clipPoint(kDots == 1 ? quad : 2 * quad), b = kDots == 1 ? a : clipPoint(2 * quad + 1);
  // points behind the near plane have no position in the image
  const float near_a = a.z, near_b = b.z;
  if (near_a < 0 && near_b >= 0) a = mix(a, b, near_a / (near_a - near_b));
  if (near_b < 0 && near_a >= 0) b = mix(b, a, near_b / (near_b - near_a));
  const vec2 half_size = 0.5 * args.viewport;
  const vec2 pixel_a = a.xy / a.w * half_size, pixel_b = b.xy / b.w * half_size;
  segment_length = length(pixel_b - pixel_a);
  const vec2 along = segment_length > 1e-4 ? (pixel_b - pixel_a) / segment_length : vec2(1, 0);
  const vec2 across = vec2(-along.y, along.x);
  const float reach = 0.5 * args.width + 1;  // one pixel for the soft edge

  const bool at_b = corner == 1 || corner == 2 || corner == 4, left = corner == 2 || corner == 4 || corner == 5;
  const vec4 end = at_b ? b : a;
  const vec2 offset = (at_b ? reach : -reach) * along + (left ? reach : -reach) * across;
  along_across = vec2(at_b ? segment_length + reach : -reach, left ? reach : -reach);
  gl_Position = near_a < 0 && near_b < 0 ? vec4(2, 2, 2, 1) : vec4(end.xy + offset / half_size * end.w, end.zw);
}
