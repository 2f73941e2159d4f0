#version 460
// SPDX-License-Identifier: MIT
// Where the object ends: pixels whose score is less than half of one nearby are the smear of an edge. 64 pixels an invocation.
#extension GL_GOOGLE_include_directive : require
#include "shaders/picture.glsl"
#include "shaders/silhouette_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { EdgeArgs args; };

const int kReach = 1;  // pixels: chroma is coded at half the resolution

// The bits of a row's word that are pixels.
uint pixelsOf(Picture camera, uint word) {
  return word + 1 < camera.row_words || camera.width % 32 == 0 ? ~0u : (1u << camera.width % 32) - 1;
}

void main() {
  const Picture camera = pictureOf(args.cameras, gl_WorkGroupID.y);
  const uint row_pairs = camera.row_words / 2;
  const uint y = gl_GlobalInvocationID.x / row_pairs, pair = gl_GlobalInvocationID.x % row_pairs;
  if (y >= camera.height) return;
  const uint own = camera.mask_words / 2 + gl_GlobalInvocationID.x;
  const uint64_t one = args.levels.at[kScoreLevels * own];
  if (one == 0ul) {
    args.masks.at[own] = 0ul;
    return;
  }

  // within reach: pixels with a score of 4, of 8, and background
  uint64_t near[kScoreLevels];
  for (uint level = 0; level < kScoreLevels; ++level) near[level] = 0ul;
  for (int dy = -kReach; dy <= kReach; ++dy) {
    const uint row = y + uint(dy);  // wraps below 0: not less than the height
    if (row >= camera.height) continue;
    const uint at = camera.mask_words / 2 + row * row_pairs + pair;
    for (uint level = 0; level < kScoreLevels; ++level) {
      if (level == 1) continue;
      const uint64_t flip = level == 0 ? ~0ul : 0ul;
      const uint64_t here = args.levels.at[kScoreLevels * at + level] ^ flip;
      const uint64_t before = pair > 0 ? args.levels.at[kScoreLevels * (at - 1) + level] ^ flip : 0ul;
      const uint64_t behind = pair + 1 < row_pairs ? args.levels.at[kScoreLevels * (at + 1) + level] ^ flip : 0ul;
      near[level] |= here;
      for (int dx = 1; dx <= kReach; ++dx)
        near[level] |= here << dx | before >> (64 - dx) | here >> dx | behind << (64 - dx);
    }
  }
  // [1, 2) beside 4 or more, and [2, 4) beside 8 or more, are less than half
  const uint64_t two = args.levels.at[kScoreLevels * own + 1], four = args.levels.at[kScoreLevels * own + 2];
  const uint64_t smear = (~two & near[2]) | (~four & near[3]);
  args.masks.at[own] = one & ~(smear & near[0]);
}
