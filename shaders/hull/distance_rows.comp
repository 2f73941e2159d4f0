#version 460
// SPDX-License-Identifier: MIT
// Squared distance along x from every cell to the nearest occupied and to the nearest empty one: one invocation per row, all cells at once
// by dilating the row's bits.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "shaders/hull/distance_io.h"
#include "shaders/hull/occupancy.glsl"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint kUnitStride = 1;  // cells are voxels: whole blocks of a row are read at once
layout(push_constant, scalar) uniform Push { DistanceRowArgs args; };

// Moves eight bits to the low bits of eight bytes.
uint64_t spread(uint64_t bits) {
  uint64_t x = bits & 0xFFul;
  x = (x | x << 28) & 0x0000000F0000000Ful;
  x = (x | x << 14) & 0x0003000300030003ul;
  return (x | x << 7) & 0x0101010101010101ul;
}

uint64_t rowOfVoxels(ivec3 low) {
  const uint bricks_edge = (args.voxels + kBrickVoxels - 1) / kBrickVoxels;
  uint64_t row = 0ul;
  for (uint g = 0; g < args.place.size[0] / kGroup; ++g) {
    const int x = low.x + int(kGroup * g);
    if (x < 0 || x >= int(args.voxels)) continue;
    const uvec3 voxel = uvec3(x, low.yz);
    const uint state = args.brick_states.at[brickIndex(voxel / kBrickVoxels, bricks_edge)];
    uint bits = state == kBrickFull ? 0xFFu : 0u;
    if (state == kBrickMixed) {
      const uint word = blockWord(voxel, bricks_edge) + (voxel.z >> 1 & 1u);
      const uint shift = 4 * (voxel.y & 3u) + 16 * (voxel.z & 1u);
      bits = (args.words.at[word] >> shift & 15u) | (args.words.at[word + 2] >> shift & 15u) << 4;
    }
    row |= uint64_t(bits) << (kGroup * g);
  }
  return row;
}

uint64_t rowOfCells(ivec3 low) {
  const uint bricks_edge = (args.voxels + kBrickVoxels - 1) / kBrickVoxels;
  const int middle = int(args.place.stride / 2);
  uint64_t row = 0ul;
  for (uint i = 0; i < args.place.size[0]; ++i) {
    const int x = low.x + int(i * args.place.stride) + middle;
    if (x >= 0 && x < int(args.voxels) &&
        occupied(args.brick_states, args.words, bricks_edge, uvec3(x, low.y + middle, low.z + middle)))
      row |= 1ul << i;
  }
  return row;
}

// Writes d² into the bytes of the cells at distance d from a set bit, d = 0 … reach; reach² farther away.
void writeSquares(uint64_t bits, int reach_cells, uint at) {
  const uint reach = uint(reach_cells);
  uint64_t rings[kFieldReach + 1];  // cells at exactly this distance
  uint64_t reached = bits;
  rings[0] = bits;
  [[unroll]] for (uint d = 1; d < reach; ++d) {
    const uint64_t next = reached | reached << 1 | reached >> 1;
    rings[d] = next & ~reached;
    reached = next;
  }
  for (uint g = 0; g < args.place.size[0] / kGroup; ++g) {
    uint64_t squares = spread(~reached >> (kGroup * g)) * (reach * reach);
    [[unroll]] for (uint d = 1; d < reach; ++d) squares |= spread(rings[d] >> (kGroup * g)) * (d * d);
    args.squares.at[at + g] = squares;
  }
}

void main() {
  const uint row = gl_GlobalInvocationID.x;  // y + size_y z
  const uint rows = args.place.size[1] * args.place.size[2];
  if (row >= rows) return;
  const ivec3 low = ivec3(args.place.low[0], args.place.low[1], args.place.low[2]) +
                    int(args.place.stride) * ivec3(0, row % args.place.size[1], row / args.place.size[1]);
  const ivec3 sampled = low + ivec3(0, ivec2(args.place.stride / 2));
  uint64_t bits = 0ul;
  if (sampled.y >= 0 && sampled.y < int(args.voxels) && sampled.z >= 0 && sampled.z < int(args.voxels))
    bits = kUnitStride != 0 ? rowOfVoxels(low) : rowOfCells(low);
  const uint groups = args.place.size[0] / kGroup;
  const uint64_t cells = ~0ul >> (64 - args.place.size[0]);
  writeSquares(bits, kFieldReach, row * groups);
  writeSquares(~bits & cells, kFieldInnerReach, (rows + row) * groups);
}
