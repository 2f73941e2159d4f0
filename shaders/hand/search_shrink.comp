#version 460
// SPDX-License-Identifier: MIT
// The mean probability of the hand in the four blocks of a tile.
#extension GL_GOOGLE_include_directive : require
#include "shaders/camera/image_layout.glsl"
#include "shaders/hand/search_io.h"
#include "shaders/silhouette/evidence.glsl"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { SearchShrinkArgs args; };

void main() {
  const TileLayout tiles = tileLayoutOf(imageLayoutOf(args.cameras, gl_WorkGroupID.y));
  if (gl_GlobalInvocationID.x >= tiles.columns * tiles.rows) return;
  const uint tile_x = gl_GlobalInvocationID.x % tiles.columns, tile_y = gl_GlobalInvocationID.x / tiles.columns;
  uint word = 0;
  for (uint half_ = 0; half_ < 2; ++half_) {
    vec2 sums = vec2(0);
    for (uint row = 0; row < 2; ++row) {
      const uint four = args.evidence.at[cellIndex(tiles, kTileCells * tile_x, kTileCells * tile_y + 2 * half_ + row) / 4];
      for (uint x = 0; x < 4; ++x) {
        const float evidence = (float(four >> (8 * x + 1) & 127u) - float(kEvidenceZero)) / kEvidenceSteps;
        sums[x / 2] += 1 / (1 + exp(-evidence));
      }
    }
    word |= (uint(63.75 * sums.x + 0.5) | uint(63.75 * sums.y + 0.5) << 8) << (16 * half_);
  }
  args.blocks.at[tiles.first_tile + gl_GlobalInvocationID.x] = word;
}
