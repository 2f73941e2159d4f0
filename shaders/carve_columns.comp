#version 460
// SPDX-License-Identifier: MIT
// Summed-area tables of the masks, second half: one invocation two columns of tiles.
#extension GL_GOOGLE_include_directive : require
#include "shaders/carve_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { CarveTableArgs args; };

void main() {
  const uint line = gl_GlobalInvocationID.x;
  const uint camera_index = line / args.max_lines;
  if (camera_index >= args.camera_count) return;
  const uint pair = line % args.max_lines;
  const uint pairs = tableStride(args.cameras.at[camera_index].tiles_x) / 2;
  if (pair >= pairs) return;

  uvec2 sum = uvec2(0);
  uint at = args.cameras.at[camera_index].table_words / 2 + pair;
  const uint tiles_y = args.cameras.at[camera_index].tiles_y;
  for (uint y = 0; y < tiles_y; ++y) {
    at += pairs;
    sum += unpackUint2x32(args.tables.at[at]);
    args.tables.at[at] = packUint2x32(sum);
  }
}
