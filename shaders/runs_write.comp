#version 460
// SPDX-License-Identifier: MIT
// The mask that is left: the largest part alone, or the mask with its small holes closed. One invocation a row.
#extension GL_GOOGLE_include_directive : require
#include "shaders/runs.glsl"

uint bitsFrom(uint first, uint last, uint word) {  // of the run first … last, those in this word
  const uint low = max(first, 32 * word) - 32 * word;
  const uint high = min(last, 32 * word + 31) - 32 * word;
  return (~0u << low) & (~0u >> (31 - high));
}

void main() {
  const Picture camera = pictureOf(args.cameras, gl_WorkGroupID.y);
  const uint y = gl_GlobalInvocationID.x;
  if (y >= camera.height) return;
  const uint at = runsOf(gl_WorkGroupID.y, y);
  const uint count = args.run_counts.at[gl_WorkGroupID.y * args.max_rows + y];
  const uint row = camera.mask_words + y * camera.row_words;
  for (uint w = 0; w < camera.row_words; ++w) args.result.at[row + w] = args.holes != 0 ? args.masks.at[row + w] : 0;

  uint word = 0, bits = 0;  // written when the runs leave the word
  for (uint i = 0; i < count; ++i) {
    const uint root = rootOf(at + i);
    const bool keep = args.holes != 0 ? args.areas.at[root] <= args.largest_hole : root == args.largest.at[gl_WorkGroupID.y];
    if (!keep) continue;
    const uint run = args.runs.at[at + i];
    const uint first = run & 0xFFFFu, last = run >> 16;
    for (uint w = first / 32; w <= last / 32; ++w) {
      if (w != word) {
        if (bits != 0) args.result.at[row + word] = bits | (args.holes != 0 ? args.masks.at[row + word] : 0);
        word = w;
        bits = 0;
      }
      bits |= bitsFrom(first, last, w);
    }
  }
  if (bits != 0) args.result.at[row + word] = bits | (args.holes != 0 ? args.masks.at[row + word] : 0);
}
