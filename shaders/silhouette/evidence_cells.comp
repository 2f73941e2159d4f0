#version 460
// SPDX-License-Identifier: MIT
// The colours of the cells of a tile, at the background's exposure, and the sums for the tile's light factor.
#extension GL_GOOGLE_include_directive : require
#include "shaders/camera/image_layout.glsl"
#include "shaders/silhouette/evidence_io.h"
#include "shaders/silhouette/evidence.glsl"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { EvidenceCellArgs args; };

void main() {
  const ImageLayout camera = imageLayoutOf(args.cameras, gl_WorkGroupID.y);
  const TileLayout tiles = tileLayoutOf(camera);
  const GpuTileRegion region = args.regions.at[gl_WorkGroupID.y];
  const uint columns = region.high[0] - region.low[0];
  if (gl_GlobalInvocationID.x >= columns * (region.high[1] - region.low[1])) return;
  const uint tile_x = region.low[0] + gl_GlobalInvocationID.x % columns, tile_y = region.low[1] + gl_GlobalInvocationID.x / columns;
  const vec3 per_gain = 0.25 / vec3(args.gains.at[4 * gl_WorkGroupID.y], args.gains.at[4 * gl_WorkGroupID.y + 1],
                                    args.gains.at[4 * gl_WorkGroupID.y + 2]);
  float seen_background = 0, background_background = 0, seen_seen = 0;
  for (uint row = 0; row < kTileCells; ++row) {
    vec3 sums[kTileCells];
    for (uint x = 0; x < kTileCells; ++x) sums[x] = vec3(0);
    for (uint line = 0; line < 2; ++line) {
      // 24 bytes of eight pixels, in seven words unless they start at a whole word
      const uint first = 3 * ((kEvidenceTile * tile_y + 2 * row + line) * camera.width + kEvidenceTile * tile_x);
      const uint word = camera.image_words + first / 4, shift = 8 * (first & 3u);
      uint low = args.images.at[word];
      uint bytes[6];
      for (uint i = 0; i < 6; ++i) {
        const uint high = args.images.at[word + i + 1];
        bytes[i] = uint(packUint2x32(uvec2(low, high)) >> shift);
        low = high;
      }
      for (uint half_ = 0; half_ < 2; ++half_) {  // four pixels in three words
        const uint a = bytes[3 * half_], b = bytes[3 * half_ + 1], c = bytes[3 * half_ + 2];
        sums[2 * half_] += vec3(a & 255u, a >> 8 & 255u, a >> 16 & 255u) + vec3(a >> 24, b & 255u, b >> 8 & 255u);
        sums[2 * half_ + 1] += vec3(b >> 16 & 255u, b >> 24, c & 255u) + vec3(c >> 8 & 255u, c >> 16 & 255u, c >> 24);
      }
    }
    for (uint x = 0; x < kTileCells; ++x) {
      const uint cell = cellIndex(tiles, kTileCells * tile_x + x, kTileCells * tile_y + row);
      const uint word = packColour(sums[x] * per_gain);
      args.colours.at[cell] = word;
      const vec3 seen = unpackColour(word), background = unpackColour(args.background.at[cell].colour);
      seen_background += dot(seen, background);
      background_background += dot(background, background);
      seen_seen += dot(seen, seen);
    }
  }
  const uint tile = tiles.first_tile + tile_y * tiles.columns + tile_x;
  args.sums.at[kTileSums * tile] = seen_background;
  args.sums.at[kTileSums * tile + 1] = background_background;
  args.sums.at[kTileSums * tile + 2] = seen_seen;
}
