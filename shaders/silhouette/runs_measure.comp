#version 460
// SPDX-License-Identifier: MIT
// The area of each connected part, stored at its root, and whether it touches the image's border: one invocation per row.
#extension GL_GOOGLE_include_directive : require
#include "shaders/silhouette/runs.glsl"

void main() {
  const ImageLayout camera = imageLayoutOf(args.cameras, gl_WorkGroupID.y);
  const uint y = gl_GlobalInvocationID.x;
  if (y >= camera.height) return;
  const uint at = runsOf(gl_WorkGroupID.y, y);
  const uint count = args.run_counts.at[gl_WorkGroupID.y * args.max_rows + y];
  for (uint i = 0; i < count; ++i) {
    const uint root = rootOf(at + i);
    const uint run = args.runs.at[at + i];
    const uint first = run & 0xFFFFu, last = run >> 16;
    atomicAdd(args.areas.at[root], last - first + 1);
    if (y == 0 || y + 1 == camera.height || first == 0 || last + 1 == camera.width)
      atomicOr(args.areas.at[root], kBorderArea);
  }
}
