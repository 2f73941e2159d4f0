#version 460
// SPDX-License-Identifier: MIT
// The runs of set (holes: of unset) pixels in a row: one invocation a row.
#extension GL_GOOGLE_include_directive : require
#include "shaders/runs.glsl"

void main() {
  const Picture camera = pictureOf(args.cameras, gl_WorkGroupID.y);
  const uint y = gl_GlobalInvocationID.x;
  if (y >= camera.height) return;
  const uint at = runsOf(gl_WorkGroupID.y, y);

  uint count = 0, first = 0;
  bool inside = false;
  for (uint w = 0; w < camera.row_words; ++w) {
    uint word = args.masks.at[camera.mask_words + y * camera.row_words + w];
    if (args.holes != 0) word = ~word;
    const uint pixels = 32 * w < camera.width ? min(32u, camera.width - 32 * w) : 0;
    if (pixels < 32) word &= (1u << pixels) - 1;
    // jump from change to change
    uint x = 0;
    while (true) {
      const uint rest = (inside ? ~word : word) & (~0u << x);
      if (rest == 0) break;
      x = findLSB(rest);
      if (!inside) {
        first = 32 * w + x;
      } else if (count < kMaxRuns) {
        args.runs.at[at + count++] = first | (32 * w + x - 1) << 16;
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
