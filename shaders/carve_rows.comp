#version 460
// SPDX-License-Identifier: MIT
// Summed-area tables of the masks, first half: one invocation a row of tiles.
#extension GL_GOOGLE_include_directive : require
#include "shaders/carve_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { CarveTableArgs args; };

// Bit i of the result: whether bits i·tile … i·tile + tile - 1 of `word` are all (any: pass the complement, complement the result) set.
uint tilesAllSet(uint word, uint tile) {
  uint folded = word;
  for (uint shift = 1; shift < tile; shift <<= 1) folded &= folded >> shift;
  return folded;
}

void main() {
  const uint line = gl_GlobalInvocationID.x;
  const uint camera_index = line / args.max_lines;
  if (camera_index >= args.camera_count) return;
  const GpuCamera camera = args.cameras.at[camera_index];
  const uint row = line % args.max_lines;
  if (row >= camera.tiles_y) return;

  const uint stride = camera.tiles_x + 1;
  const uint plane = stride * (camera.tiles_y + 1);
  const uint any_at = camera.table_words + (row + 1) * stride;
  const uint all_at = any_at + plane;
  if (row == 0)
    for (uint x = 0; x < stride; ++x) {
      args.tables.at[camera.table_words + x] = 0;
      args.tables.at[camera.table_words + plane + x] = 0;
    }
  args.tables.at[any_at] = 0;
  args.tables.at[all_at] = 0;

  const uint y_end = min((row + 1) * camera.tile, camera.height);
  const uint tiles_a_word = 32 / camera.tile;
  uint any_sum = 0, all_sum = 0, x = 0;
  for (uint w = 0; w < camera.row_words; ++w) {
    uint any_bits = 0, all_bits = ~0u;
    for (uint y = row * camera.tile; y < y_end; ++y) {
      const uint word = args.masks.at[camera.mask_words + y * camera.row_words + w];
      any_bits |= word;
      all_bits &= word;
    }
    // pixels behind the right edge do not exist: they keep no tile from being all set
    const uint pixels = camera.width - 32 * w;
    if (pixels < 32) all_bits |= ~0u << pixels;
    const uint none = tilesAllSet(~any_bits, camera.tile);
    const uint all = tilesAllSet(all_bits, camera.tile);
    for (uint t = 0; t < tiles_a_word && x < camera.tiles_x; ++t) {
      any_sum += ~none >> (t * camera.tile) & 1u;
      all_sum += all >> (t * camera.tile) & 1u;
      ++x;
      args.tables.at[any_at + x] = any_sum;
      args.tables.at[all_at + x] = all_sum;
    }
  }
}
