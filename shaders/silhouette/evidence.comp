#version 460
// SPDX-License-Identifier: MIT
// The log-likelihood ratio of hand and everything else, for a row of four cells of a tile.
#extension GL_GOOGLE_include_directive : require
#include "shaders/camera/image_layout.glsl"
#include "shaders/silhouette/evidence_io.h"
#include "shaders/silhouette/evidence.glsl"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { EvidenceArgs args; };

float square(float x) { return x * x; }

// Of a tile: image times background, background squared, and the squared residual.
vec3 sumsOf(uint tile) {
  const float both = args.sums.at[kTileSums * tile], background = args.sums.at[kTileSums * tile + 1];
  const float light = clamp(both / (background + 1), args.least_light, kMostLight);
  return vec3(both, background, args.sums.at[kTileSums * tile + 2] - 2 * light * both + light * light * background);
}

void main() {
  const TileLayout tiles = tileLayoutOf(imageLayoutOf(args.cameras, gl_WorkGroupID.y));
  const GpuTileRegion region = args.regions.at[gl_WorkGroupID.y];
  const uint columns = region.high[0] - region.low[0];
  const uint tile = gl_GlobalInvocationID.x / kTileCells, row = gl_GlobalInvocationID.x % kTileCells;
  if (tile >= columns * (region.high[1] - region.low[1])) return;
  const uint tile_x = region.low[0] + tile % columns, tile_y = region.low[1] + tile / columns;

  // the sums of three tiles in a row, interpolated between the two rows of tiles that are nearest
  const float v = (float(row) + 0.5) / float(kTileCells) - 0.5;
  const uint other_y = uint(clamp(int(tile_y) + (v < 0 ? -1 : 1), int(region.low[1]), int(region.high[1]) - 1));
  vec3 sums[3];
  for (int i = 0; i < 3; ++i) {
    const uint x = uint(clamp(int(tile_x) + i - 1, int(region.low[0]), int(region.high[0]) - 1));
    sums[i] = mix(sumsOf(tiles.first_tile + tile_y * tiles.columns + x), sumsOf(tiles.first_tile + other_y * tiles.columns + x), abs(v));
  }

  const uint table = 2 * kColourTable * gl_WorkGroupID.y;
  const uint first = cellIndex(tiles, kTileCells * tile_x, kTileCells * tile_y + row);
  uint word = 0;
  for (uint x = 0; x < kTileCells; ++x) {
    const float u = (float(x) + 0.5) / float(kTileCells) - 0.5;
    const vec3 sum = mix(sums[1], sums[u < 0 ? 0 : 2], abs(u));
    const float light = clamp(sum.x / (sum.y + 1), args.least_light, kMostLight);
    const uint colour = args.colours.at[first + x];
    const GpuCellBackground cell = args.background.at[first + x];
    const vec3 seen = unpackColour(colour), residual = seen - light * unpackColour(cell.colour);
    const float variance = cell.variance + square(kTextureNoise / 3 * (seen.x + seen.y + seen.z));
    const float tile_distance = sum.z / (2 * variance * float(kTileCells * kTileCells));
    const float distance_ = dot(residual, residual) / (2 * variance) + clamp(args.texture_trust * (tile_distance - kTileNoise), -kTileChange, kTileChange);
    const bool changed = distance_ + square(max(0, kChangedLight - light) / kChangedLightSpread) > kChangedResidual;
    // densities relative to the uniform one, 256⁻³
    const float unlikely = square(max(0, kDimmest - light) / kDimmerSpread) + square(max(0, light - kBrighter) / kBrighterSpread);
    const float background = 16777216 * exp(-clamp(distance_, 0, 40) - unlikely) / pow(6.2831853 * variance, 1.5);
    const uint bin = colourBin(seen);
    const float hand = args.tables.at[table + bin], other = args.tables.at[table + kColourTable + bin];
    const float evidence = log(hand) - log(kBackgroundPrior * background + (1 - kBackgroundPrior) * other);
    const uint value = uint(float(kEvidenceZero) + 0.5 + kEvidenceSteps * clamp(evidence, -kMaxEvidence, kMaxEvidence));
    word |= (value << 1 | uint(changed)) << (8 * x);
  }
  args.evidence.at[first / 4] = word;
}
