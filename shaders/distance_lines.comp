#version 460
// SPDX-License-Identifier: MIT
// The squared distances of one more dimension: min over the line of (what the line's cells know) + (distance along it)², as
// the exact Euclidean distance transform separates (Saito and Toriwaki 1994). One invocation a cell, from near to far, until nothing nearer can come.
#extension GL_GOOGLE_include_directive : require
#include "shaders/distance_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { DistanceLineArgs args; };

void main() {
  const uint cell = gl_GlobalInvocationID.x;
  const int along = int(cell / args.axis_step % kFieldCells);
  const uint own = args.squares.at[cell];
  uint full = own & 0xFFFFu, empty = own >> 16;
  for (int step = 1; step <= kFieldReach; ++step) {
    const uint square = uint(step * step);
    const bool inner = step <= kFieldInnerReach && square < empty;
    if (square >= full && !inner) break;
    for (int side = -1; side <= 1; side += 2) {
      const int at = along + side * step;
      if (at < 0 || at >= int(kFieldCells)) continue;
      const uint other = args.squares.at[uint(int(cell) + side * step * int(args.axis_step))];
      full = min(full, (other & 0xFFFFu) + square);
      empty = min(empty, (other >> 16) + square);
    }
  }
  if (uint64_t(args.distances) == 0ul) {
    args.next_squares.at[cell] = full | empty << 16;
    return;
  }
  // the surface lies half a cell before the nearest cell of the other kind
  const float outside = min(sqrt(float(full)), float(kFieldReach)) - 0.5;
  const float inside = min(sqrt(float(empty)), float(kFieldInnerReach)) - 0.5;
  args.distances.at[cell] = args.cell_m * (full > 0 ? outside : -inside);
}
