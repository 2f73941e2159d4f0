#version 460
// SPDX-License-Identifier: MIT
// The largest part of each camera, the first one on a tie: one workgroup per camera.
#extension GL_GOOGLE_include_directive : require
#include "shaders/silhouette/runs.glsl"

shared uvec2 best[kSilhouetteWorkgroup];  // area, label

bool better(uvec2 a, uvec2 b) { return a.x > b.x || (a.x == b.x && a.y < b.y); }

void main() {
  const ImageLayout camera = imageLayoutOf(args.cameras, gl_WorkGroupID.y);
  uvec2 mine = uvec2(0, ~0u);
  for (uint y = gl_LocalInvocationID.x; y < camera.height; y += gl_WorkGroupSize.x) {
    const uint at = runsOf(gl_WorkGroupID.y, y);
    const uint count = args.run_counts.at[gl_WorkGroupID.y * args.max_rows + y];
    for (uint i = 0; i < count; ++i) {
      if (args.labels.at[at + i] != at + i) continue;
      const uvec2 part = uvec2(args.areas.at[at + i] & ~kBorderArea, at + i);
      if (better(part, mine)) mine = part;
    }
  }
  best[gl_LocalInvocationID.x] = mine;
  barrier();
  if (gl_LocalInvocationID.x != 0) return;
  for (uint i = 1; i < gl_WorkGroupSize.x; ++i)
    if (better(best[i], mine)) mine = best[i];
  args.largest.at[gl_WorkGroupID.y] = mine.y;
}
