#version 460
// SPDX-License-Identifier: MIT
// Finds the runs of set pixels (with holes: of unset pixels) in a row: one invocation per row.
#extension GL_GOOGLE_include_directive : require
#include "shaders/silhouette/runs.glsl"

void main() {
  const ImageLayout camera = imageLayoutOf(args.cameras, gl_WorkGroupID.y);
  const uint y = gl_GlobalInvocationID.x;
  if (y >= camera.height) return;
  const uint at = runsOf(gl_WorkGroupID.y, y);

  uint count = 0, first = 0;
  bool inside = false;
  const uint row_pairs = camera.row_words / 2;
  for (uint pair = 0; pair < row_pairs; ++pair) {
    uint64_t word = args.masks.at[camera.mask_words / 2 + y * row_pairs + pair];
    if (args.holes != 0) word = ~word;
    const uint pixels = camera.width - 64 * pair;
    if (pixels < 64) word &= (1ul << pixels) - 1ul;
    // jump from change to change
    uint x = 0;
    while (true) {
      const uvec2 rest = unpackUint2x32((inside ? ~word : word) & (~0ul << x));
      if ((rest.x | rest.y) == 0) break;
      x = rest.x != 0 ? findLSB(rest.x) : 32 + findLSB(rest.y);
      if (!inside) {
        first = 64 * pair + x;
      } else if (count < kMaxRuns) {
        args.runs.at[at + count++] = first | (64 * pair + x - 1) << 16;
      }
      inside = !inside;
    }
  }
  if (inside && count < kMaxRuns) args.runs.at[at + count++] = first | (camera.width - 1) << 16;

  args.run_counts.at[gl_WorkGroupID.y * args.max_rows + y] = count;
  for (uint i = 0; i < count; ++i) {
    args.labels.at[at + i] = at + i;
    args.areas.at[at + i] = 0;
  }
}
