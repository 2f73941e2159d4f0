#version 460
// SPDX-License-Identifier: MIT
// Any and all over tiles of the masks: one invocation 32 tiles of a row, that is 128 x 4 pixels.
#extension GL_GOOGLE_include_directive : require
#include "shaders/carve_io.h"
#include "shaders/picture.glsl"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { CarveTileArgs args; };

// A bit for each four: whether all are set.
uint fours(uint64_t bits) {
  bits &= bits >> 1;
  bits = bits & bits >> 2 & 0x1111111111111111ul;
  bits = (bits | bits >> 3) & 0x0303030303030303ul;
  bits = (bits | bits >> 6) & 0x000F000F000F000Ful;
  bits = (bits | bits >> 12) & 0x000000FF000000FFul;
  return uint(bits | bits >> 24) & 0xFFFFu;
}

void main() {
  if (gl_WorkGroupID.y == 0 && gl_GlobalInvocationID.x < kHullSumWords) {
    args.sums.at[gl_GlobalInvocationID.x] = 0;
    if (gl_GlobalInvocationID.x < kMixedSizes) args.mixed_counts.at[gl_GlobalInvocationID.x] = MixedCount(0, 1, 1, 0);
  }
  const Picture camera = pictureOf(args.cameras, gl_WorkGroupID.y);
  const uint row_pairs = camera.row_words / 2, entries = (row_pairs + 1) / 2;
  const uint row = gl_GlobalInvocationID.x / entries, entry = gl_GlobalInvocationID.x % entries;
  if (row * kTilePixels >= camera.height) return;

  const uint mask = camera.mask_words / 2;
  const uint end = min((row + 1) * kTilePixels, camera.height);
  uint any_tiles = 0, all_tiles = 0;
  for (uint k = 0; k < 2; ++k) {
    const uint pair = 2 * entry + k;
    uint64_t any_bits = 0ul, all_bits = ~0ul;
    if (pair < row_pairs) {
      for (uint y = row * kTilePixels; y < end; ++y) {
        const uint64_t word = args.masks.at[mask + y * row_pairs + pair];
        any_bits |= word;
        all_bits &= word;
      }
      // pixels behind the right edge do not exist: they keep no tile from being all set
      const uint pixels = 64 * pair < camera.width ? camera.width - 64 * pair : 0;
      if (pixels < 64) all_bits |= ~0ul << pixels;
    }
    any_tiles |= (~fours(~any_bits) & 0xFFFFu) << (16 * k);
    all_tiles |= fours(all_bits) << (16 * k);
  }
  args.tiles.at[camera.first_entry + row * entries + entry] = packUint2x32(uvec2(any_tiles, all_tiles));
}
