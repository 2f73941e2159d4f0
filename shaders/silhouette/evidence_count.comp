#version 460
// SPDX-License-Identifier: MIT
// Counts the colours of the hand and of everything else that moves, from the fitted hand, for one camera.
#extension GL_GOOGLE_include_directive : require
#include "shaders/camera/image_layout.glsl"
#include "shaders/silhouette/evidence_io.h"
#include "shaders/silhouette/evidence.glsl"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { EvidenceCountArgs args; };

void main() {
  const ImageLayout image = imageLayoutOf(args.cameras, args.camera);
  const TileLayout tiles = tileLayoutOf(image);
  const GpuTileRegion region = args.regions.at[args.camera];
  const uint columns = region.high[0] - region.low[0];
  const uint tile = gl_GlobalInvocationID.x / kTileCells;
  if (tile >= columns * (region.high[1] - region.low[1])) return;
  const uint first_x = kTileCells * (region.low[0] + tile % columns);
  const uint y = kTileCells * (region.low[1] + tile / columns) + gl_GlobalInvocationID.x % kTileCells;

  // bit 2 (x - first_x + kOutsideCells) + j of a column: whether the hand covers that pixel in any, and in all, of the rows around
  const int low_x = 2 * (int(first_x) - kOutsideCells);
  uint any_near = 0, all_inside = ~0u;
  for (int dy = -kOutsideCells; dy <= kOutsideCells; ++dy)
    for (int line = 0; line < 2; ++line) {
      const int row = 2 * (int(y) + dy) + line;
      uint bits = 0;  // of the 24 pixels from low_x
      if (row >= 0 && row < int(image.height)) {
        const uint first = image.mask_words + uint(row) * image.row_words;
        const int word = low_x >> 5;  // rounds down
        const uint low = word >= 0 ? args.masks.at[first + uint(word)] : 0u;
        const uint high = word + 1 < int(image.row_words) ? args.masks.at[first + uint(word + 1)] : 0u;
        bits = uint(packUint2x32(uvec2(low, high)) >> (low_x & 31));
      }
      any_near |= bits;
      if (abs(dy) <= kInsideCells) all_inside &= bits;
    }

  const vec4 from = args.forearms.at[2 * args.camera], to = args.forearms.at[2 * args.camera + 1];
  const vec2 along = to.xy - from.xy;
  const uint first_cell = cellIndex(tiles, first_x, y);
  const uint evidence = args.evidence.at[first_cell / 4];
  uint totals[2] = uint[2](0, 0);
  for (uint x = 0; x < kTileCells; ++x) {
    const uint inside = 0x3fu << (2 * (x + uint(kOutsideCells) - uint(kInsideCells))), near = 0x3ffffu << (2 * x);
    const vec2 offset = vec2(2 * (first_x + x) + 0.5, 2 * y + 0.5) - from.xy;
    const float place = clamp(dot(offset, along) / max(dot(along, along), 1e-6), 0, 1);
    uint histogram = 2;
    if ((all_inside & inside) == inside) histogram = 0;
    else if ((any_near & near) == 0 && (evidence >> (8 * x) & 1u) != 0 && length(offset - place * along) > from.z) histogram = 1;
    if (histogram == 2) continue;
    const uint bin = colourBin(unpackColour(args.colours.at[first_cell + x]));
    atomicAdd(args.counts.at[histogram * kColourCounts + bin], 1);
    ++totals[histogram];
  }
  for (uint histogram = 0; histogram < 2; ++histogram)
    if (totals[histogram] > 0) atomicAdd(args.counts.at[histogram * kColourCounts + kColourTable], totals[histogram]);
}
