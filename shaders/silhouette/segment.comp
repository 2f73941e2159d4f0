#version 460
// SPDX-License-Identifier: MIT
// How far 64 pixels differ from the background, per invocation. A pixel I is split into a brightness α E of the background's mean E, which
// a shadow or a change of light scales, and a residual of different colour (the decomposition of Horprasert, Harwood and Davis 1999).
#extension GL_GOOGLE_include_directive : require
#include "shaders/camera/image_layout.glsl"
#include "shaders/silhouette/silhouette_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { SegmentArgs args; };

vec3 channels(uint word) { return vec3(word & 255u, word >> 8 & 255u, word >> 16 & 255u); }

uint64_t words[kScoreLevels];  // of this invocation

// Adds pixel `bit` to the words of the levels that its score reaches. Scores are compared as squares.
void addPixel(uint pixel, uint model, uint bit) {
  const vec3 seen = channels(pixel), expected = channels(model);
  const float tolerance = (kColourSpreads * kSpreadStep) * float(model >> 24);
  const float square = max(dot(expected, expected), 1.0), along = dot(seen, expected);  // α = along / square
  const float root = inversesqrt(square);
  // |I - α E|², and |α - 1| over its limit; the brightness of a dark background is mostly noise: its spread widens both limits
  const float rest = dot(seen, seen) - along * along * root * root;
  const float change = abs(along - square);
  const float allowed = (along > square ? kBrightest - 1 : 1 - kDarkest) * square + tolerance * square * root;
  const float score = max(rest / (tolerance * tolerance), change * change / (allowed * allowed));
  for (uint level = 0; level < kScoreLevels; ++level) words[level] |= score >= float(1u << 2 * level) ? 1ul << bit : 0ul;
}

// The general case: four pixels span three words, or parts of four.
void addPixels(ImageLayout camera, uint first, uint count) {
  for (uint i = 0; i < count; i += 4) {
    const uint byte = 3 * (first + i), shift = 8 * (byte & 3u);
    const uint at = camera.image_words + byte / 4;
    uvec3 bytes = uvec3(args.images.at[at], args.images.at[at + 1], args.images.at[at + 2]);
    if (shift != 0) bytes = bytes >> shift | uvec3(bytes.yz, args.images.at[at + 3]) << (32 - shift);
    const uint pixels[4] = {bytes.x, bytes.x >> 24 | bytes.y << 8, bytes.y >> 16 | bytes.z << 16, bytes.z >> 8};
    for (uint k = 0; k < 4 && i + k < count; ++k)
      addPixel(pixels[k], args.model.at[camera.pixels_before + first + i + k], i + k);
  }
}

// Images whose width is a multiple of eight: eight pixels are three pairs of words, their models four.
void addPixelsInPairs(ImageLayout camera, uint first, uint count) {
  ReadPairs images = ReadPairs(uint64_t(args.images));
  ReadPairs model = ReadPairs(uint64_t(args.model));
  for (uint i = 0; i < count; i += 8) {
    const uint at = camera.image_words / 2 + 3 * ((first + i) / 8);
    const uint64_t a = images.at[at], b = images.at[at + 1], c = images.at[at + 2];
    const uint pixels[8] = {uint(a), uint(a >> 24), uint(a >> 48) | uint(b) << 16, uint(b >> 8),
                            uint(b >> 32), uint(b >> 56) | uint(c) << 8, uint(c >> 16), uint(c >> 40)};
    for (uint k = 0; k < 4; ++k) {
      const uvec2 models = unpackUint2x32(model.at[(camera.pixels_before + first + i) / 2 + k]);
      addPixel(pixels[2 * k], models.x, i + 2 * k);
      addPixel(pixels[2 * k + 1], models.y, i + 2 * k + 1);
    }
  }
}

void main() {
  const ImageLayout camera = imageLayoutOf(args.cameras, gl_WorkGroupID.y);
  const uint row_pairs = camera.row_words / 2;
  const uint y = gl_GlobalInvocationID.x / row_pairs, pair = gl_GlobalInvocationID.x % row_pairs;
  if (y >= camera.height) return;
  for (uint level = 0; level < kScoreLevels; ++level) words[level] = 0ul;
  const uint first = y * camera.width + 64 * pair;
  const uint count = min(64u, camera.width - 64 * pair);
  if (kSameWidth != 0 && kSameWidth % 8 == 0) addPixelsInPairs(camera, first, count);
  else addPixels(camera, first, count);

  const uint at = kScoreLevels * (camera.mask_words / 2 + gl_GlobalInvocationID.x);
  for (uint level = 0; level < kScoreLevels; ++level) args.levels.at[at + level] = words[level];
}
