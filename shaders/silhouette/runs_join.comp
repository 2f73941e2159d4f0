#version 460
// SPDX-License-Identifier: MIT
// Joins the runs of a row with those that they touch in the row above: one invocation per row.
#extension GL_GOOGLE_include_directive : require
#include "shaders/silhouette/runs.glsl"

void join(uint a, uint b) {
  while (true) {
    a = rootOf(a);
    b = rootOf(b);
    if (a == b) return;
    const uint low = min(a, b), high = max(a, b);
    const uint before = atomicMin(args.labels.at[high], low);
    if (before == high) return;  // it was still a root, and now points to `low`
    a = before;
    b = low;
  }
}

void main() {
  const ImageLayout camera = imageLayoutOf(args.cameras, gl_WorkGroupID.y);
  const uint y = gl_GlobalInvocationID.x + 1;
  if (y >= camera.height) return;
  const uint row = gl_WorkGroupID.y * args.max_rows + y;
  const uint here = runsOf(gl_WorkGroupID.y, y), above = here - kMaxRuns;
  const uint here_count = args.run_counts.at[row], above_count = args.run_counts.at[row - 1];
  const uint reach = args.holes != 0 ? 0 : 1;  // eight-connected: corners touch
  uint i = 0, k = 0;
  while (i < here_count && k < above_count) {
    const uint a = args.runs.at[here + i], b = args.runs.at[above + k];
    const uint a_last = a >> 16, b_last = b >> 16;
    if ((a & 0xFFFFu) <= b_last + reach && (b & 0xFFFFu) <= a_last + reach) join(here + i, above + k);
    if (a_last < b_last) ++i;
    else ++k;
  }
}
