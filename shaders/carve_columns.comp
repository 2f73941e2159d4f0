#version 460
// SPDX-License-Identifier: MIT
// Summed-area tables of the masks, second half: one invocation a column of tiles.
#extension GL_GOOGLE_include_directive : require
#include "shaders/carve_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { CarveTableArgs args; };

void main() {
  const uint line = gl_GlobalInvocationID.x;
  const uint camera_index = line / args.max_lines;
  if (camera_index >= args.camera_count) return;
  const GpuCamera camera = args.cameras.at[camera_index];
  const uint column = line % args.max_lines + 1;  // column 0 is zeros
  if (column > camera.tiles_x) return;

  const uint stride = camera.tiles_x + 1;
  const uint plane = stride * (camera.tiles_y + 1);
  uint any_sum = 0, all_sum = 0;
  uint at = camera.table_words + column;
  for (uint y = 0; y < camera.tiles_y; ++y) {
    at += stride;
    any_sum += args.tables.at[at];
    all_sum += args.tables.at[at + plane];
    args.tables.at[at] = any_sum;
    args.tables.at[at + plane] = all_sum;
  }
}
