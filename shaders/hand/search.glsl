// SPDX-License-Identifier: MIT
// Looks up the probability of the hand in a block. The including shader's arguments have a member `blocks`.

#include "shaders/camera/image_layout.glsl"
#include "shaders/silhouette/evidence.glsl"

// The probability at a block, -1 outside the tiles.
float probabilityAt(TileLayout tiles, ivec2 block) {
  if (block.x < 0 || block.y < 0 || block.x >= int(2 * tiles.columns) || block.y >= int(2 * tiles.rows)) return -1;
  const uint word = args.blocks.at[tiles.first_tile + uint(block.y >> 1) * tiles.columns + uint(block.x >> 1)];
  return float(word >> (16 * (block.y & 1) + 8 * (block.x & 1)) & 255u) / 255;
}
