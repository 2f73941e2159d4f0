// SPDX-License-Identifier: MIT
// The layout of tiles and cells, and packed colours.

struct TileLayout {
  uint columns, rows;  // of tiles
  uint first_tile, first_cell;
};

TileLayout tileLayoutOf(ImageLayout image) {
  return TileLayout(image.width / kEvidenceTile, image.height / kEvidenceTile, image.pixels_before / 64, 4 * (image.pixels_before / 16));
}

uint cellIndex(TileLayout tiles, uint x, uint y) { return tiles.first_cell + y * (kTileCells * tiles.columns) + x; }

vec3 unpackColour(uint word) { return kCellColourStep * vec3(word & 1023u, word >> 10 & 1023u, word >> 20 & 1023u); }

uint packColour(vec3 colour) {
  const uvec3 q = uvec3(clamp(colour / kCellColourStep + 0.5, vec3(0), vec3(1023)));
  return q.x | q.y << 10 | q.z << 20;
}

uint colourBin(vec3 colour) {
  const uvec3 bin = min(uvec3(colour * (float(kColourBins) / 256)), uvec3(kColourBins - 1));
  return (bin.x * kColourBins + bin.y) * kColourBins + bin.z;
}
