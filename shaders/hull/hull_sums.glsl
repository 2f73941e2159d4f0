// SPDX-License-Identifier: MIT
// Adds to the hull's volume and centre of gravity (HullSums of carve_io.h) as blocks are decided.
#extension GL_KHR_shader_subgroup_arithmetic : require

#include "shaders/hull/carve_io.h"

// A full block's sums: count and sums of x, y, z over its `edge`³ voxels from `low_voxel`. At most 2^25 for a block of 32, so the blocks of
// a workgroup fit 32 bits.
uvec4 fullShare(uvec3 low_voxel, uint edge) {
  const uint count = edge * edge * edge;
  return uvec4(count, count * low_voxel + count * (edge - 1) / 2);
}

// The sums of a 4³ block, bits as in carve_io.h: bits 0 and 1 of a bit's index are x, 2 and 3 are y, 4 and 5 are z.
uvec4 wordsShare(uvec3 low_voxel, uint low_word, uint high_word) {
  const uint high_count = bitCount(high_word), count = bitCount(low_word) + high_count;
  const uint x = bitCount(low_word & 0xAAAAAAAAu) + bitCount(high_word & 0xAAAAAAAAu) +
                 2 * (bitCount(low_word & 0xCCCCCCCCu) + bitCount(high_word & 0xCCCCCCCCu));
  const uint y = bitCount(low_word & 0xF0F0F0F0u) + bitCount(high_word & 0xF0F0F0F0u) +
                 2 * (bitCount(low_word & 0xFF00FF00u) + bitCount(high_word & 0xFF00FF00u));
  const uint z = bitCount(low_word & 0xFFFF0000u) + bitCount(high_word & 0xFFFF0000u) + 2 * high_count;
  return uvec4(count, count * low_voxel + uvec3(x, y, z));
}

// Adds the subgroup's sums: a number in two words with its carry.
void addToSums(ReadWriteUints sums, uvec4 share) {
  share = subgroupAdd(share);
  if (subgroupElect() && share.x > 0)
    for (uint k = 0; k < 4; ++k)
      if (atomicAdd(sums.at[2 * k], share[k]) > ~share[k]) atomicAdd(sums.at[2 * k + 1], 1);
}
