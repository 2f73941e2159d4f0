#version 460
// SPDX-License-Identifier: MIT
// Exclusive prefix sums of the bricks' counts: each invocation sums a contiguous part, then the parts are summed.
#extension GL_GOOGLE_include_directive : require
#include "shaders/render/renderer_voxels_io.h"

layout(local_size_x = kVoxelScanWorkgroup) in;
layout(push_constant, scalar) uniform Push { VoxelScanArgs args; };
shared uint share_sums[kVoxelScanWorkgroup];

void main() {
  const uint me = gl_LocalInvocationID.x;
  const uint share = (args.brick_count + kVoxelScanWorkgroup - 1) / kVoxelScanWorkgroup;
  const uint begin = min(me * share, args.brick_count), end = min(begin + share, args.brick_count);
  uint sum = 0;
  for (uint i = begin; i < end; ++i) sum += args.counts.at[i];
  share_sums[me] = sum;
  barrier();
  uint first = 0;
  for (uint i = 0; i < me; ++i) first += share_sums[i];
  for (uint i = begin; i < end; ++i) {
    args.firsts.at[i] = first;
    first += args.counts.at[i];
  }
  if (me == kVoxelScanWorkgroup - 1) {
    const uint total = min(first, args.capacity);
    args.totals.at[0] = VoxelCounts(kVoxelVertices, total, 0, 0, (total + kRenderWorkgroup - 1) / kRenderWorkgroup, 1, 1);
  }
}
