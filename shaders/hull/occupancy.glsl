// SPDX-License-Identifier: MIT
// Reads the brick-wise voxel model.

#include "shaders/hull/carve_io.h"

uint brickIndex(uvec3 brick, uint bricks_edge) {
  return brick.x + bricks_edge * (brick.y + bricks_edge * brick.z);
}

// The first of the two words of the 4³ block that contains `voxel`.
uint blockWord(uvec3 voxel, uint bricks_edge) {
  const uvec3 block = (voxel / kBlockVoxels) & 1u;
  return brickIndex(voxel / kBrickVoxels, bricks_edge) * kBrickWords + 2 * (block.x + 2 * block.y + 4 * block.z);
}

bool occupied(ReadUints brick_states, ReadUints words, uint bricks_edge, uvec3 voxel) {
  const uint state = brick_states.at[brickIndex(voxel / kBrickVoxels, bricks_edge)];
  if (state != kBrickMixed) return state == kBrickFull;
  const uvec3 in_block = voxel & (kBlockVoxels - 1);
  const uint bit = in_block.x + 4 * in_block.y + 16 * in_block.z;
  return (words.at[blockWord(voxel, bricks_edge) + bit / 32] >> (bit & 31u) & 1u) != 0;
}
