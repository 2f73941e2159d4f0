#version 460
// SPDX-License-Identifier: MIT
// Builds the pyramid of densities from the areas in the finest cells: a parent has four times the face area and eight children.
#extension GL_GOOGLE_include_directive : require
#include "shaders/render/renderer_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { RenderLevelArgs args; };

const uint kFine = kDensityCells, kMiddle = kFine / 2, kCoarse = kFine / 4;

void main() {
  const uint me = gl_GlobalInvocationID.x;
  if (me >= kCoarse * kCoarse * kCoarse) return;
  const uvec3 coarse = uvec3(me % kCoarse, me / kCoarse % kCoarse, me / (kCoarse * kCoarse));
  float in_coarse = 0;
  for (uint i = 0; i < 8; ++i) {
    const uvec3 middle = 2 * coarse + uvec3(i & 1, i >> 1 & 1, i >> 2);
    float in_middle = 0;
    for (uint j = 0; j < 8; ++j) {
      const uvec3 fine = 2 * middle + uvec3(j & 1, j >> 1 & 1, j >> 2);
      const uint at = fine.x + kFine * (fine.y + kFine * fine.z);
      const float area = args.areas.at[at] / kDensityUnit;
      args.densities.at[at] = area;
      in_middle += area;
    }
    args.densities.at[kFine * kFine * kFine + middle.x + kMiddle * (middle.y + kMiddle * middle.z)] = in_middle / 4;
    in_coarse += in_middle;
  }
  args.densities.at[kFine * kFine * kFine + kMiddle * kMiddle * kMiddle + me] = in_coarse / 16;
}
