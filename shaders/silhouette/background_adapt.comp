#version 460
// SPDX-License-Identifier: MIT
// Replaces the background of a cell's pixels after a lasting change.
#extension GL_GOOGLE_include_directive : require
#include "shaders/camera/image_layout.glsl"
#include "shaders/silhouette/evidence_io.h"
#include "shaders/silhouette/evidence.glsl"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { BackgroundAdaptArgs args; };

ivec3 channels(uint word) { return ivec3(word & 255u, word >> 8 & 255u, word >> 16 & 255u); }
uint packed(ivec3 colour) { return uint(colour.x) | uint(colour.y) << 8 | uint(colour.z) << 16; }
bool isWithin(uint levels, ivec3 a, ivec3 b) { return all(lessThanEqual(abs(a - b), ivec3(levels))); }

void main() {
  const ImageLayout camera = imageLayoutOf(args.cameras, gl_WorkGroupID.y);
  const TileLayout tiles = tileLayoutOf(camera);
  const GpuTileRegion region = args.regions.at[gl_WorkGroupID.y];
  const uint columns = kTileCells * tiles.columns;
  const uint x = gl_GlobalInvocationID.x % columns, y = gl_GlobalInvocationID.x / columns * kAdaptRows + args.phase;
  const uint tile_x = x / kTileCells, tile_y = y / kTileCells;
  if (tile_y >= tiles.rows) return;
  if (tile_x >= region.low[0] && tile_y >= region.low[1] && tile_x < region.high[0] && tile_y < region.high[1]) return;
  const vec3 per_gain = 1 / vec3(args.gains.at[4 * gl_WorkGroupID.y], args.gains.at[4 * gl_WorkGroupID.y + 1], args.gains.at[4 * gl_WorkGroupID.y + 2]);

  ivec3 sum = ivec3(0);
  float variance = 0;
  for (uint k = 0; k < 4; ++k) {
    const uint pixel = (2 * y + (k >> 1)) * camera.width + 2 * x + (k & 1u);
    const uint word = camera.image_words + 3 * pixel / 4, shift = 8 * (3 * pixel & 3u);
    const uint bytes = uint(packUint2x32(uvec2(args.images.at[word], args.images.at[word + 1])) >> shift);
    const ivec3 seen = min(ivec3(vec3(channels(bytes)) * per_gain + 0.5), ivec3(255));
    const uint model = args.model.at[camera.pixels_before + pixel], candidate = args.candidates.at[camera.pixels_before + pixel];
    ivec3 mean = channels(model);
    uint visits = 0, other = packed(seen);
    if (!isWithin(kAdaptNoise, seen, mean) && isWithin(kAdaptSame, seen, channels(candidate))) {
      visits = (candidate >> 24) + 1;
      other = candidate & 0xffffffu;
      if (visits >= kAdaptVisits) {
        mean = channels(candidate);
        visits = 0;
      }
    }
    args.candidates.at[camera.pixels_before + pixel] = other | visits << 24;
    args.model.at[camera.pixels_before + pixel] = packed(mean) | (model & 0xff000000u);
    sum += mean;
    const float spread = kSpreadStep * float(model >> 24);
    variance += 0.25 * spread * spread;
  }
  args.cells.at[cellIndex(tiles, x, y)] = GpuCellBackground(packColour(0.25 * vec3(sum)), variance);
}
