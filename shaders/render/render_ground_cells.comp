#version 460
// SPDX-License-Identifier: MIT
// The triangles of the ground's cells on which a shadow lies; of the others, none that can be seen: there the backdrop, which
// the ground repeats, is the image already.
#extension GL_GOOGLE_include_directive : require
#include "shaders/render/renderer_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { RenderGroundArgs args; };

const float kFull = 0.998;  // more light than that: the shade is less than a step of 8 bits

bool shaded(uint vertex) { return min(args.lights.at[vertex].key, args.lights.at[vertex].open_front) < kFull; }

void main() {
  const uint cells = args.side - 1, me = gl_GlobalInvocationID.x;
  if (me >= cells * cells) return;
  const uint low = me % cells + args.side * (me / cells), high = low + args.side;
  const bool drawn = shaded(low) || shaded(low + 1) || shaded(high) || shaded(high + 1);
  const uint corners[6] = {low, low + 1, high + 1, low, high + 1, high};
  for (uint i = 0; i < 6; ++i) args.triangles.at[6 * me + i] = drawn ? corners[i] : 0;
}
