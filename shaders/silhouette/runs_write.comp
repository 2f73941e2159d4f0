#version 460
// SPDX-License-Identifier: MIT
// Writes the cleaned mask: the largest part alone, or the mask with its small holes closed. One invocation per row.
#extension GL_GOOGLE_include_directive : require
#include "shaders/silhouette/runs.glsl"

uint64_t bitsFrom(uint first, uint last, uint pair) {  // the bits of the run first … last that are in this pair of words
  const uint low = max(first, 64 * pair) - 64 * pair;
  const uint high = min(last, 64 * pair + 63) - 64 * pair;
  return (~0ul << low) & (~0ul >> (63 - high));
}

void main() {
  const ImageLayout camera = imageLayoutOf(args.cameras, gl_WorkGroupID.y);
  const uint y = gl_GlobalInvocationID.x;
  if (y >= camera.height) return;
  const uint at = runsOf(gl_WorkGroupID.y, y);
  const uint count = args.run_counts.at[gl_WorkGroupID.y * args.max_rows + y];
  const uint row_pairs = camera.row_words / 2;
  const uint row = camera.mask_words / 2 + y * row_pairs;
  for (uint pair = 0; pair < row_pairs; ++pair) args.result.at[row + pair] = args.holes != 0 ? args.masks.at[row + pair] : 0ul;

  uint current = 0;
  uint64_t bits = 0ul;  // written when the runs leave the pair
  for (uint i = 0; i < count; ++i) {
    const uint root = rootOf(at + i);
    const bool keep = args.holes != 0 ? args.areas.at[root] <= args.largest_hole : root == args.largest.at[gl_WorkGroupID.y];
    if (!keep) continue;
    const uint run = args.runs.at[at + i];
    const uint first = run & 0xFFFFu, last = run >> 16;
    for (uint pair = first / 64; pair <= last / 64; ++pair) {
      if (pair != current) {
        if (bits != 0ul) args.result.at[row + current] = bits | (args.holes != 0 ? args.masks.at[row + current] : 0ul);
        current = pair;
        bits = 0ul;
      }
      bits |= bitsFrom(first, last, pair);
    }
  }
  if (bits != 0ul) args.result.at[row + current] = bits | (args.holes != 0 ? args.masks.at[row + current] : 0ul);
}
