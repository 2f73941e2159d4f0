#version 460
// SPDX-License-Identifier: MIT
// Smoothed colour densities from a camera's histograms.
#extension GL_GOOGLE_include_directive : require
#include "shaders/silhouette/evidence_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { EvidenceTableArgs args; };

void main() {
  const uint row = gl_GlobalInvocationID.x, histogram = gl_WorkGroupID.y;
  if (row >= kColourBins * kColourBins) return;
  const uint first = (2 * args.camera + histogram) * kColourTable;
  const ivec2 at = ivec2(row / kColourBins, row % kColourBins);
  const float uniform_ = histogram == 0 ? kHandUniform : kOtherUniform;
  const float factor = (1 - uniform_) * float(kColourTable) / 64;
  float before = 0, here = 0;  // sums over the other two channels
  for (uint z = 0; z <= kColourBins; ++z) {
    float next = here;  // the last bin repeats past the end
    if (z < kColourBins) {
      next = 0;
      for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y) {
          const uvec2 near = uvec2(clamp(at + ivec2(x, y), ivec2(0), ivec2(kColourBins - 1)));
          next += float((2 - abs(x)) * (2 - abs(y))) * args.histograms.at[first + (near.x * kColourBins + near.y) * kColourBins + z];
        }
    }
    if (z == 0) before = next;
    else args.tables.at[first + row * kColourBins + z - 1] = factor * (before + 2 * here + next) + uniform_;
    before = z == 0 ? next : here;
    here = next;
  }
}
