#version 460
// SPDX-License-Identifier: MIT
// Lists the voxels of the model's surface: occupied, with at least one of the six neighbours empty.
#extension GL_GOOGLE_include_directive : require
#include "shaders/hull/occupancy.glsl"
#include "shaders/render/renderer_voxels_io.h"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint kWrites = 0;
layout(push_constant, scalar) uniform Push { VoxelListArgs args; };

bool filled(ivec3 voxel) {
  if (any(lessThan(voxel, ivec3(0))) || any(greaterThanEqual(voxel, ivec3(args.voxels)))) return false;
  return occupied(args.brick_states, args.words, args.bricks_edge, uvec3(voxel));
}

bool onSurface(ivec3 v) {
  return filled(v) && !(filled(v + ivec3(1, 0, 0)) && filled(v - ivec3(1, 0, 0)) && filled(v + ivec3(0, 1, 0)) &&
                        filled(v - ivec3(0, 1, 0)) && filled(v + ivec3(0, 0, 1)) && filled(v - ivec3(0, 0, 1)));
}

// Points away from the occupied voxels within two steps.
vec3 outwards(ivec3 v) {
  vec3 sum = vec3(0, 0, 1e-4);
  for (int z = -2; z <= 2; ++z)
    for (int y = -2; y <= 2; ++y)
      for (int x = -2; x <= 2; ++x)
        if (filled(v + ivec3(x, y, z))) sum -= vec3(x, y, z);
  return normalize(sum);
}

void main() {
  const uint brick = gl_GlobalInvocationID.x, edge = args.bricks_edge;
  if (brick >= edge * edge * edge) return;
  uint count = 0;
  if (args.brick_states.at[brick] != kBrickEmpty) {
    const ivec3 low = ivec3(brick % edge, brick / edge % edge, brick / (edge * edge)) * int(kBrickVoxels);
    for (uint i = 0; i < kBrickVoxels * kBrickVoxels * kBrickVoxels; ++i) {
      const ivec3 voxel = low + ivec3(i & 7, i >> 3 & 7, i >> 6);
      if (!onSurface(voxel)) continue;
      if (kWrites == 1) {
        const uint at = args.firsts.at[brick] + count;
        if (at < args.capacity) {
          args.positions.at[at] = (vec3(voxel) + 0.5 - 0.5 * args.voxels) * args.voxel_m;
          args.normals.at[at] = outwards(voxel);
        }
      }
      ++count;
    }
  }
  if (kWrites == 0) args.counts.at[brick] = count;
}
