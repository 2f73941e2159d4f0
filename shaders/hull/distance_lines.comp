#version 460
// SPDX-License-Identifier: MIT
// Squared distances in one more dimension: the minimum over the line of (each cell's value) + (distance along the line)², for the eight
// cells of a word at once and kFieldRun words of a line per invocation: byte arithmetic inside 64 bits, values below 128.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "shaders/hull/distance_io.h"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint kLast = 0;  // 1: the pass along z, which writes metres
layout(push_constant, scalar) uniform Push { DistanceLineArgs args; };

const uint64_t kOnes = 0x0101010101010101ul;
const uint kOutputs = kFieldRun + kLast;  // the last pass also needs the upper neighbour of its run
const uint kMostInputs = kFieldRun + 1 + 2 * kFieldReach;

// The byte-wise minimum. All bytes are below 128: a's byte with its high bit set is never less than b's.
uint64_t lesser(uint64_t a, uint64_t b) {
  const uint64_t greater = ((a | kOnes << 7) - b) >> 7 & kOnes;  // 1 where a >= b
  const uint64_t mask = (greater << 8) - greater;
  return (b & mask) | (a & ~mask);
}

// The run's squared distances, from plane `plane` with distances up to `reach`; there is nothing beyond the line's ends.
void minimize(uint plane, uint first, int along, int reach, out uint64_t outputs[kFieldRun + 1]) {
  const uint64_t far = kOnes * uint64_t(reach * reach);
  uint64_t inputs[kMostInputs];
  [[unroll]] for (int i = 0; i < int(kOutputs) + 2 * reach; ++i) {
    const int at = along + i - reach;
    inputs[i] = at >= 0 && at < int(args.line_cells) ? args.squares.at[plane + first + uint(i - reach) * args.step] : far;
  }
  [[unroll]] for (int o = 0; o < int(kOutputs); ++o) {
    uint64_t best = inputs[o + reach];
    [[unroll]] for (int d = 1; d < reach; ++d) {
      const uint64_t square = kOnes * uint64_t(d * d);
      best = lesser(best, lesser(inputs[o + reach - d], inputs[o + reach + d]) + square);
    }
    outputs[o] = best;
  }
}

// The surface is half a cell before the nearest cell of the other kind.
float signedDistance(uint64_t full, uint64_t empty, uint cell) {
  const float outside = sqrt(float(uint(full >> (8 * cell)) & 127u)), inside = sqrt(float(uint(empty >> (8 * cell)) & 127u));
  return args.cell_m * (outside > 0 ? outside - 0.5 : 0.5 - inside);
}

void main() {
  // adjacent groups map to adjacent invocations
  const uint runs = args.line_cells / kFieldRun;
  const uint line = gl_GlobalInvocationID.x % args.step + gl_GlobalInvocationID.x / (args.step * runs) * args.step * args.line_cells;
  const uint along = gl_GlobalInvocationID.x / args.step % runs * kFieldRun;
  if (gl_GlobalInvocationID.x >= args.groups / kFieldRun) return;
  const uint first = line + along * args.step;

  uint64_t full[kFieldRun + 1], empty[kFieldRun + 1];
  minimize(0, first, int(along), kFieldReach, full);
  minimize(args.groups, first, int(along), kFieldInnerReach, empty);
  [[unroll]] for (uint i = 0; i < kFieldRun; ++i) {
    const uint at = first + i * args.step;
    if (kLast == 0) {
      args.next_squares.at[at] = full[i];
      args.next_squares.at[args.groups + at] = empty[i];
    } else {
      [[unroll]] for (uint cell = 0; cell < kGroup; ++cell)
        args.distances.at[kGroup * at + cell] = packUint2x32(floatBitsToUint(
            vec2(signedDistance(full[i], empty[i], cell), signedDistance(full[i + 1], empty[i + 1], cell))));
    }
  }
}
