#version 460
// SPDX-License-Identifier: MIT
// The triangles of the ground cells that are in shadow. Other cells get degenerate triangles: there the image already shows the backdrop,
// which the ground repeats.
#extension GL_GOOGLE_include_directive : require
#include "shaders/render/renderer_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { RenderGroundArgs args; };

const float kFull = 0.998;  // with more light than this the shade is below one 8-bit step

bool shaded(uint vertex) { return min(args.lights.at[vertex].key, args.lights.at[vertex].open_front) < kFull; }

void main() {
  const uint cells = args.side - 1, me = gl_GlobalInvocationID.x;
  if (me >= cells * cells) return;
  const uint low = me % cells + args.side * (me / cells), high = low + args.side;
  const bool drawn = shaded(low) || shaded(low + 1) || shaded(high) || shaded(high + 1);
  const uint corners[6] = {low, low + 1, high + 1, low, high + 1, high};
  for (uint i = 0; i < 6; ++i) args.triangles.at[6 * me + i] = drawn ? corners[i] : 0;
}
