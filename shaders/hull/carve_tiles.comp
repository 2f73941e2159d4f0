#version 460
// SPDX-License-Identifier: MIT
// Any and all over tiles of the masks: one invocation per band of 128 x 16 pixels.
#extension GL_GOOGLE_include_directive : require
#include "shaders/hull/carve_io.h"
#include "shaders/camera/image_layout.glsl"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { CarveTileArgs args; };

// One bit per group of four: whether all four are set.
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
  const ImageLayout camera = imageLayoutOf(args.cameras, gl_WorkGroupID.y);
  const uint row_pairs = camera.row_words / 2, entries = (row_pairs + 1) / 2;
  const uint band = gl_GlobalInvocationID.x / entries, entry = gl_GlobalInvocationID.x % entries;
  if (band * kLargeTilePixels >= camera.height) return;

  const uint mask = camera.mask_words / 2;
  const uint first_entry = camera.first_entry + band * kBandRows * entries + entry;
  uint any_band = 0, all_band = ~0u;
  for (uint row = 0; row < kLargeTilePixels / kTilePixels; ++row) {
    const uint low = band * kLargeTilePixels + row * kTilePixels, high = min(low + kTilePixels, camera.height);
    uint any_tiles = 0, all_tiles = 0;
    for (uint k = 0; k < 2; ++k) {
      const uint pair = 2 * entry + k;
      uint64_t any_bits = 0ul, all_bits = ~0ul;
      if (pair < row_pairs) {
        for (uint y = low; y < high; ++y) {
          const uint64_t word = args.masks.at[mask + y * row_pairs + pair];
          any_bits |= word;
          all_bits &= word;
        }
        // pixels past the right edge do not exist: they do not keep a tile from being all set
        const uint pixels = 64 * pair < camera.width ? camera.width - 64 * pair : 0;
        if (pixels < 64) all_bits |= ~0ul << pixels;
      }
      any_tiles |= (~fours(~any_bits) & 0xFFFFu) << (16 * k);
      all_tiles |= fours(all_bits) << (16 * k);
    }
    args.tiles.at[first_entry + row * entries] = packUint2x32(uvec2(any_tiles, all_tiles));
    any_band |= any_tiles;
    all_band &= all_tiles;
  }
  // four tiles of four rows make a large tile
  const uvec2 large = uvec2(~fours(~uint64_t(any_band)), fours(all_band)) & 0xFFu;
  args.tiles.at[first_entry + (kBandRows - 1) * entries] = packUint2x32(large);
}
