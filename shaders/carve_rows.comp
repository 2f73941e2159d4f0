#version 460
// SPDX-License-Identifier: MIT
// Summed-area tables of the masks, first half: one invocation a row of tiles, 64 pixels at a time.
#extension GL_GOOGLE_include_directive : require
#include "shaders/carve_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { CarveTableArgs args; };

// Bit i · tile of the result: whether bits i · tile … (i + 1) · tile - 1 are all set.
uint64_t allOfTile(uint64_t bits, uint tile) {
  for (uint shift = 1; shift < tile; shift <<= 1) bits &= bits >> shift;
  return bits;
}

void main() {
  const uint line = gl_GlobalInvocationID.x;
  const uint camera_index = line / args.max_lines;
  if (camera_index >= args.camera_count) return;
  const uint row = line % args.max_lines;
  const uint tiles_y = args.cameras.at[camera_index].tiles_y;
  if (row >= tiles_y) return;
  const uint tiles_x = args.cameras.at[camera_index].tiles_x, tile = args.cameras.at[camera_index].tile;
  const uint width = args.cameras.at[camera_index].width, height = args.cameras.at[camera_index].height;
  const uint row_words = args.cameras.at[camera_index].row_words;

  const uint pairs = tableStride(tiles_x) / 2;
  const uint table = args.cameras.at[camera_index].table_words / 2;
  if (row == 0)
    for (uint x = 0; x < pairs; ++x) args.tables.at[table + x] = 0ul;
  uint at = table + (row + 1) * pairs;

  const uint mask = (args.cameras.at[camera_index].mask_words + row * tile * row_words) / 2;
  const uint rows = min(tile, height - row * tile);
  uint sum = 0, even = 0, x = 0;  // entry 0 is the column of zeros; `even` waits for its odd neighbour
  for (uint w = 0; w < row_words / 2; ++w) {
    uint64_t any_bits = 0ul, all_bits = ~0ul;
    for (uint y = 0; y < rows; ++y) {
      const uint64_t word = args.masks.at[mask + y * (row_words / 2) + w];
      any_bits |= word;
      all_bits &= word;
    }
    // pixels behind the right edge do not exist: they keep no tile from being all set
    const uint pixels = width - 64 * w;
    if (pixels < 64) all_bits |= ~0ul << pixels;
    const uint64_t none = allOfTile(~any_bits, tile), all = allOfTile(all_bits, tile);
    for (uint bit = 0; bit < 64 && x < tiles_x; bit += tile) {
      sum += (uint(~none >> bit) & 1u) << 16 | (uint(all >> bit) & 1u);
      ++x;
      if ((x & 1u) != 0) args.tables.at[at++] = packUint2x32(uvec2(even, sum));
      even = sum;
    }
  }
  if ((x & 1u) == 0) args.tables.at[at] = packUint2x32(uvec2(even, even));
}
