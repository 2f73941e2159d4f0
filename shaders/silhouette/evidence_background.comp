#version 460
// SPDX-License-Identifier: MIT
// The background of a cell from those of its four pixels.
#extension GL_GOOGLE_include_directive : require
#include "shaders/camera/image_layout.glsl"
#include "shaders/silhouette/evidence_io.h"
#include "shaders/silhouette/evidence.glsl"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { EvidenceBackgroundArgs args; };

void main() {
  const ImageLayout camera = imageLayoutOf(args.cameras, args.first_camera + gl_WorkGroupID.y);
  const TileLayout tiles = tileLayoutOf(camera);
  const uint columns = kTileCells * tiles.columns;
  const uint x = gl_GlobalInvocationID.x % columns, y = gl_GlobalInvocationID.x / columns;
  if (y >= kTileCells * tiles.rows) return;
  vec3 colour = vec3(0);
  float variance = 0;
  for (uint k = 0; k < 4; ++k) {
    const uint word = args.model.at[camera.pixels_before + (2 * y + (k >> 1)) * camera.width + 2 * x + (k & 1u)];
    colour += 0.25 * vec3(word & 255u, word >> 8 & 255u, word >> 16 & 255u);
    const float spread = kSpreadStep * float(word >> 24);
    variance += 0.25 * spread * spread;
  }
  args.cells.at[cellIndex(tiles, x, y)] = GpuCellBackground(packColour(colour), variance);
}
