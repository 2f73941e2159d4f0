#version 460
// SPDX-License-Identifier: MIT
// Object or background, for 32 pixels an invocation. A pixel I is compared with the background's mean E as a brightness α E, which a
// shadow or a change of light scales, and a rest of other colour (the decomposition of Horprasert, Harwood and Davis 1999).
#extension GL_GOOGLE_include_directive : require
#include "shaders/silhouette_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { SegmentArgs args; };

vec3 channels(uint word) { return vec3(word & 255u, word >> 8 & 255u, word >> 16 & 255u); }

bool isObject(uint pixel, uint model) {
  const vec3 seen = channels(pixel), expected = channels(model);
  const float spread = kSpreadStep * float(model >> 24);
  const float square = max(dot(expected, expected), 1.0);
  const float alpha = dot(seen, expected) / square;
  const vec3 rest = seen - alpha * expected;
  const float tolerance = kColourSpreads * spread;
  // the brightness of a dark background is mostly noise: its spread widens both limits
  const float slack = tolerance * inversesqrt(square);
  return dot(rest, rest) > tolerance * tolerance || alpha < kDarkest - slack || alpha > kBrightest + slack;
}

void main() {
  const GpuCamera camera = args.cameras.at[gl_WorkGroupID.y];
  const uint y = gl_GlobalInvocationID.x / camera.row_words, w = gl_GlobalInvocationID.x % camera.row_words;
  if (y >= camera.height) return;
  const uint first = y * camera.width + 32 * w;
  const uint count = min(32u, camera.width - 32 * w);

  uint word = 0;
  for (uint i = 0; i < count; i += 4) {
    // four pixels are three words, or parts of four
    const uint byte = 3 * (first + i), shift = 8 * (byte & 3u);
    const uint at = camera.picture_words + byte / 4;
    uvec3 bytes = uvec3(args.pictures.at[at], args.pictures.at[at + 1], args.pictures.at[at + 2]);
    if (shift != 0) bytes = bytes >> shift | uvec3(bytes.yz, args.pictures.at[at + 3]) << (32 - shift);
    const uint pixels[4] = {bytes.x, bytes.x >> 24 | bytes.y << 8, bytes.y >> 16 | bytes.z << 16, bytes.z >> 8};
    for (uint k = 0; k < 4; ++k) {
      const uint model = args.model.at[camera.pixels_before + first + i + k];
      word |= (isObject(pixels[k], model) ? 1u : 0u) << (i + k);
    }
  }
  if (count < 32) word &= (1u << count) - 1;
  args.masks.at[camera.mask_words + y * camera.row_words + w] = word;
}
