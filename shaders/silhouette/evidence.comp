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
  vec2 sums[3];
  for (int i = 0; i < 3; ++i) {
    const uint x = uint(clamp(int(tile_x) + i - 1, int(region.low[0]), int(region.high[0]) - 1));
    const uint here = 2 * (tiles.first_tile + tile_y * tiles.columns + x), there = 2 * (tiles.first_tile + other_y * tiles.columns + x);
    sums[i] = mix(vec2(args.sums.at[here], args.sums.at[here + 1]), vec2(args.sums.at[there], args.sums.at[there + 1]), abs(v));
  }

  const uint table = 2 * kColourTable * gl_WorkGroupID.y;
  const uint first = cellIndex(tiles, kTileCells * tile_x, kTileCells * tile_y + row);
  uint word = 0;
  for (uint x = 0; x < kTileCells; ++x) {
    const float u = (float(x) + 0.5) / float(kTileCells) - 0.5;
    const vec2 sum = mix(sums[1], sums[u < 0 ? 0 : 2], abs(u));
    const float light = clamp(sum.x / (sum.y + 1), kLeastLight, kMostLight);
    const uint colour = args.colours.at[first + x];
    const GpuCellBackground cell = args.background.at[first + x];
    const vec3 seen = unpackColour(colour), residual = seen - light * unpackColour(cell.colour);
    const float variance = cell.variance + square(kTextureNoise / 3 * (seen.x + seen.y + seen.z));
    const float distance_ = dot(residual, residual) / (2 * variance);
    const bool changed = distance_ + square(max(0, kChangedLight - light) / kChangedLightSpread) > kChangedResidual;
    // densities relative to the uniform one, 256⁻³
    const float unlikely = square(max(0, kDimmest - light) / kDimmerSpread) + square(max(0, light - kBrighter) / kBrighterSpread);
    const float background = 16777216 * exp(-min(distance_, 40) - unlikely) / pow(6.2831853 * variance, 1.5);
    const uint bin = colourBin(seen);
    const float hand = args.tables.at[table + bin], other = args.tables.at[table + kColourTable + bin];
    const float evidence = log(hand) - log(kBackgroundPrior * background + (1 - kBackgroundPrior) * other);
    const uint value = uint(float(kEvidenceZero) + 0.5 + kEvidenceSteps * clamp(evidence, -kMaxEvidence, kMaxEvidence));
    word |= (value << 1 | uint(changed)) << (8 * x);
  }
  args.evidence.at[first / 4] = word;
}
