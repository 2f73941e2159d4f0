#version 460
// SPDX-License-Identifier: MIT
// Distance along x from every cell to the nearest occupied and to the nearest empty one: one invocation a row, by bit search.
#extension GL_GOOGLE_include_directive : require
#include "shaders/distance_io.h"
#include "shaders/occupancy.glsl"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { DistanceRowArgs args; };

// Cells from `x` to the nearest set bit of a row; kFieldCells when there is none.
uint nearest(uvec2 row, uint x) {
  const uint in_word = x & 31u;
  const uint here = x < 32 ? row.x : row.y;
  const uint up = here >> in_word;           // at and above x
  const uint down = here << (31 - in_word);  // at and below x
  uint distance = kFieldCells;
  if (up != 0) distance = findLSB(up);
  else if (x < 32 && row.y != 0) distance = 32 - in_word + findLSB(row.y);
  if (down != 0) distance = min(distance, 31 - findMSB(down));
  else if (x >= 32 && row.x != 0) distance = min(distance, in_word + 32 - findMSB(row.x));
  return distance;
}

void main() {
  const uint row = gl_GlobalInvocationID.x;  // y + kFieldCells z
  const ivec3 voxel = ivec3(args.place.low[0], args.place.low[1], args.place.low[2]) +
                      int(args.place.stride) * ivec3(0, row % kFieldCells, row / kFieldCells) + int(args.place.stride / 2);
  const uint bricks_edge = (args.voxels + kBrickVoxels - 1) / kBrickVoxels;
  uvec2 bits = uvec2(0);
  const int n = int(args.voxels);
  if (voxel.y >= 0 && voxel.y < n && voxel.z >= 0 && voxel.z < n)
    for (uint x = 0; x < kFieldCells; ++x) {
      const int at = voxel.x + int(x * args.place.stride);
      if (at >= 0 && at < n && occupied(args.brick_states, args.words, bricks_edge, uvec3(at, voxel.yz)))
        bits[x >> 5] |= 1u << (x & 31u);
    }
  for (uint x = 0; x < kFieldCells; ++x) {
    const uint to_full = nearest(bits, x), to_empty = nearest(~bits, x);
    const uint full = to_full < kFieldCells ? to_full * to_full : kFieldFar;
    const uint empty = to_empty < kFieldCells ? to_empty * to_empty : kFieldFar;
    args.squares.at[row * kFieldCells + x] = full | empty << 16;
  }
}
