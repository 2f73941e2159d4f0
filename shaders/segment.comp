#version 460
// SPDX-License-Identifier: MIT
// How far 32 pixels differ from the background, an invocation. A pixel I is compared with the background's mean E as a brightness α E, which a
// shadow or a change of light scales, and a rest of other colour (the decomposition of Horprasert, Harwood and Davis 1999).
#extension GL_GOOGLE_include_directive : require
#include "shaders/silhouette_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { SegmentArgs args; };

vec3 channels(uint word) { return vec3(word & 255u, word >> 8 & 255u, word >> 16 & 255u); }

// The levels that the pixel's score reaches, a bit each.
uint levelsReached(uint pixel, uint model) {
  const vec3 seen = channels(pixel), expected = channels(model);
  const float spread = kSpreadStep * float(model >> 24);
  const float square = max(dot(expected, expected), 1.0);
  const float alpha = dot(seen, expected) / square;
  const vec3 rest = seen - alpha * expected;
  const float tolerance = kColourSpreads * spread;
  // the brightness of a dark background is mostly noise: its spread widens both limits
  const float slack = tolerance * inversesqrt(square);
  const float brightness = alpha > 1 ? (alpha - 1) / (kBrightest - 1 + slack) : (1 - alpha) / (1 - kDarkest + slack);
  const float score = max(sqrt(dot(rest, rest)) / tolerance, brightness);
  return (score >= 1 ? 1u : 0u) | (score >= 2 ? 2u : 0u) | (score >= 4 ? 4u : 0u) | (score >= 8 ? 8u : 0u);
}

void main() {
  const GpuCamera camera = args.cameras.at[gl_WorkGroupID.y];
  const uint y = gl_GlobalInvocationID.x / camera.row_words, w = gl_GlobalInvocationID.x % camera.row_words;
  if (y >= camera.height) return;
  const uint first = y * camera.width + 32 * w;
  const uint count = min(32u, camera.width - 32 * w);

  uint words[kScoreLevels] = {0, 0, 0, 0};
  for (uint i = 0; i < count; i += 4) {
    // four pixels are three words, or parts of four
    const uint byte = 3 * (first + i), shift = 8 * (byte & 3u);
    const uint at = camera.picture_words + byte / 4;
    uvec3 bytes = uvec3(args.pictures.at[at], args.pictures.at[at + 1], args.pictures.at[at + 2]);
    if (shift != 0) bytes = bytes >> shift | uvec3(bytes.yz, args.pictures.at[at + 3]) << (32 - shift);
    const uint pixels[4] = {bytes.x, bytes.x >> 24 | bytes.y << 8, bytes.y >> 16 | bytes.z << 16, bytes.z >> 8};
    for (uint k = 0; k < 4; ++k) {
      const uint model = args.model.at[camera.pixels_before + first + i + k];
      const uint reached = i + k < count ? levelsReached(pixels[k], model) : 0;
      for (uint level = 0; level < kScoreLevels; ++level) words[level] |= (reached >> level & 1u) << (i + k);
    }
  }
  const uint at = kScoreLevels * (camera.mask_words + y * camera.row_words + w);
  for (uint level = 0; level < kScoreLevels; ++level) args.levels.at[at + level] = words[level];
}
