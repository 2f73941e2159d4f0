#version 460
// SPDX-License-Identifier: MIT
// The pixels that are more likely the hand than not, as a mask.
#extension GL_GOOGLE_include_directive : require
#include "shaders/camera/image_layout.glsl"
#include "shaders/silhouette/evidence_io.h"
#include "shaders/silhouette/evidence.glsl"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { EvidenceMaskArgs args; };

void main() {
  const ImageLayout image = imageLayoutOf(args.cameras, gl_WorkGroupID.y);
  const TileLayout tiles = tileLayoutOf(image);
  const GpuTileRegion region = args.regions.at[gl_WorkGroupID.y];
  const uint word = gl_GlobalInvocationID.x % image.row_words, cell_y = gl_GlobalInvocationID.x / image.row_words;
  if (2 * cell_y >= image.height) return;
  uint bits = 0;
  const uint tile_y = cell_y / kTileCells;
  if (tile_y >= region.low[1] && tile_y < region.high[1])
    for (uint k = 0; k < 4; ++k) {
      const uint tile_x = 4 * word + k;
      if (tile_x < region.low[0] || tile_x >= region.high[0]) continue;
      const uint four = args.evidence.at[cellIndex(tiles, kTileCells * tile_x, cell_y) / 4];
      for (uint x = 0; x < 4; ++x)
        if ((four >> (8 * x + 1) & 127u) > kEvidenceZero) bits |= 3u << (8 * k + 2 * x);
    }
  for (uint line = 0; line < 2; ++line)
    if (2 * cell_y + line < image.height) args.masks.at[image.mask_words + (2 * cell_y + line) * image.row_words + word] = bits;
}
