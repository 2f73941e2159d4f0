#version 460
// SPDX-License-Identifier: MIT
// Volume and centre of gravity of the voxel model: the paper's fit starts there.
#extension GL_GOOGLE_include_directive : require
#include "shaders/carve_io.h"

layout(local_size_x = 1) in;
layout(push_constant, scalar) uniform Push { CarveTotalArgs args; };

void main() {
  uint64_t total[4] = {0ul, 0ul, 0ul, 0ul};
  for (uint i = 0; i < args.partial_count; ++i)
    for (uint k = 0; k < 4; ++k) total[k] += args.partial_sums.at[4 * i + k];
  HullSummary summary;
  summary.occupied = uint(total[0]);
  summary.pad = 0;
  summary.gravity_center = vec3(0);
  if (total[0] > 0) {
    const dvec3 mean = dvec3(total[1], total[2], total[3]) / double(total[0]);
    summary.gravity_center = vec3((mean + 0.5 - 0.5 * double(args.voxels)) * double(args.voxel_m));
  }
  args.summary.at[0] = summary;
}
