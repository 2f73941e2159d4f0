#version 460
// SPDX-License-Identifier: MIT
// Smoothed colour densities from a camera's histograms.
#extension GL_GOOGLE_include_directive : require
#include "shaders/silhouette/evidence_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { EvidenceTableArgs args; };

void main() {
  const uint bin = gl_GlobalInvocationID.x, histogram = gl_WorkGroupID.y;
  if (bin >= kColourTable) return;
  const uint first = (2 * args.camera + histogram) * kColourTable;
  const ivec3 at = ivec3(bin / (kColourBins * kColourBins), bin / kColourBins % kColourBins, bin % kColourBins);
  float sum = 0;
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {
        const uvec3 near = uvec3(clamp(at + ivec3(x, y, z), ivec3(0), ivec3(kColourBins - 1)));
        sum += float((2 - abs(x)) * (2 - abs(y)) * (2 - abs(z))) * args.histograms.at[first + (near.x * kColourBins + near.y) * kColourBins + near.z];
      }
  const float uniform_ = histogram == 0 ? kHandUniform : kOtherUniform;
  args.tables.at[first + bin] = (1 - uniform_) * float(kColourTable) / 64 * sum + uniform_;
}
