#version 460
// SPDX-License-Identifier: MIT
// Blends new colour counts into a camera's histograms.
#extension GL_GOOGLE_include_directive : require
#include "shaders/silhouette/evidence_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { EvidenceHistogramArgs args; };

void main() {
  const uint bin = gl_GlobalInvocationID.x, histogram = gl_WorkGroupID.y;
  if (bin >= kColourTable) return;
  const uint counts = histogram * kColourCounts, at = (2 * args.camera + histogram) * kColourTable + bin;
  const uint total = args.counts.at[counts + kColourTable];
  if (total < kMinColours) return;
  args.histograms.at[at] = mix(args.histograms.at[at], float(args.counts.at[counts + bin]) / float(total), args.rate);
}
