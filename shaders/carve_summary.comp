#version 460
// SPDX-License-Identifier: MIT
// Count of occupied voxels and sums of their indices, in integers: one workgroup's share.
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "shaders/occupancy.glsl"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { CarveSummaryArgs args; };

shared uvec4 sums[kCarveWorkgroup];

void main() {
  uvec4 sum = uvec4(0);  // a workgroup's share is at most 64 · bricks_per_invocation bricks: 32 bits hold it (carve.cpp)
  for (uint i = 0; i < args.bricks_per_invocation; ++i) {
    const uint brick = (gl_WorkGroupID.x * args.bricks_per_invocation + i) * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    if (brick >= args.brick_count) break;
    const uint state = args.brick_states.at[brick];
    if (state == kBrickEmpty) continue;
    const uvec3 corner = kBrickVoxels * (uvec3(brick, brick / args.bricks_edge, brick / (args.bricks_edge * args.bricks_edge)) %
                                         args.bricks_edge);
    if (state == kBrickFull) {
      sum += uvec4(512, 512 * corner + 1792);  // 64 · (0 + 1 + … + 7)
      continue;
    }
    for (uint w = 0; w < kBrickWords; ++w) {
      const uint word = args.words.at[brick * kBrickWords + w];
      if (word == 0) continue;
      const uint count = bitCount(word);
      const uvec3 low = corner + uvec3(4 * (w >> 1 & 1u), 4 * (w >> 2 & 1u), 4 * (w >> 3) + 2 * (w & 1u));
      const uint x = bitCount(word & 0xAAAAAAAAu) + 2 * bitCount(word & 0xCCCCCCCCu);
      const uint y = bitCount(word & 0xF0F0F0F0u) + 2 * bitCount(word & 0xFF00FF00u);
      const uint z = bitCount(word & 0xFFFF0000u);
      sum += uvec4(count, count * low + uvec3(x, y, z));
    }
  }
  sums[gl_LocalInvocationID.x] = sum;
  barrier();
  if (gl_LocalInvocationID.x != 0) return;
  for (uint i = 1; i < gl_WorkGroupSize.x; ++i) sum += sums[i];
  for (uint k = 0; k < 4; ++k) args.partial_sums.at[4 * gl_WorkGroupID.x + k] = uint64_t(sum[k]);
}
