#version 460
// SPDX-License-Identifier: MIT
// A coarse hull from probabilities: which voxels the cameras agree on.
#extension GL_GOOGLE_include_directive : require
layout(constant_id = 3) const uint kLenses = 15;
#include "shaders/hand/search_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { SearchHullArgs args; };

#include "shaders/camera/lens.glsl"
#include "shaders/hand/search.glsl"

void main() {
  const uint runs = kHullVoxels / kHullRun;
  const uint run = gl_GlobalInvocationID.x;
  if (run >= runs * kHullVoxels * kHullVoxels) return;
  const uvec3 first = uvec3(run % runs * kHullRun, run / runs % kHullVoxels, run / (runs * kHullVoxels));
  const vec3 low = args.voxel_m * (vec3(first) + 0.5 - 0.5 * float(kHullVoxels));
  float sums[kHullRun];
  uint once = 0, twice = 0, count = 0;
  for (uint x = 0; x < kHullRun; ++x) sums[x] = 0;
  for (uint index = 0; index < args.camera_count; ++index) {
    if ((args.camera_bits >> index & 1u) == 0) continue;
    ++count;
    const GpuCamera camera = args.cameras.at[index];
    const TileLayout tiles = tileLayoutOf(imageLayoutOf(args.cameras, index));
    const vec3 origin = camera.rotation * low + camera.translation, step_ = camera.rotation[0] * args.voxel_m;
    for (uint x = 0; x < kHullRun; ++x) {
      const Projection projection = projectThroughLens(camera, origin + float(x) * step_);
      float probability = -1;
      if (projection.valid) probability = probabilityAt(tiles, ivec2(floor((projection.pixel + 0.5) / float(kBlockPixels))));
      if (probability >= 0) {
        twice |= once & 1u << x;
        once |= 1u << x;
      } else {
        probability = 0.5;
      }
      sums[x] += log(clamp(probability, kHullLeast, 1 - kHullLeast));
    }
  }
  uint word = 0;
  for (uint x = 0; x < kHullRun; ++x)
    if (sums[x] > float(count) * log(kHullProbability)) word |= 1u << x;
  args.words.at[run] = word & twice;
}
