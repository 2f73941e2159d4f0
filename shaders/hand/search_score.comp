#version 460
// SPDX-License-Identifier: MIT
// How badly a hypothetical pose agrees with the probabilities of one camera.
#extension GL_GOOGLE_include_directive : require
layout(constant_id = 3) const uint kLenses = 15;
#include "shaders/hand/search_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { SearchScoreArgs args; };

#include "shaders/camera/lens.glsl"
#include "shaders/core/quaternion.glsl"
#include "shaders/hand/outline_pose.glsl"
#include "shaders/hand/search.glsl"

shared uint cells[2 * kScoreWindow];  // the window, one bit per cell, two words per row
shared float differences[kScoreWindow];  // by row
shared uint counts[kScoreWindow];

uint64_t rowOf(int y) {
  return y < 0 || y >= int(kScoreWindow) ? 0ul : packUint2x32(uvec2(cells[2 * y], cells[2 * y + 1]));
}

void main() {
  const uint index = gl_WorkGroupID.y;
  const GpuCamera camera = args.cameras.at[index];
  const TileLayout tiles = tileLayoutOf(imageLayoutOf(args.cameras, index));
  const GpuOutlinePose pose = args.poses.at[gl_WorkGroupID.x];
  const vec3 center = camera.rotation * pose.position + camera.translation;
  const float blocks = max(1, floor(camera.focal.x * kScoreCell / (max(center.z, kNearest) * float(kBlockPixels)) + 0.5));
  const float cell_pixels = blocks * float(kBlockPixels);
  const ivec2 origin = ivec2(floor((projectThroughLens(camera, center).pixel + 0.5) / cell_pixels)) - int(kScoreWindow / 2);

  for (uint i = gl_LocalInvocationID.x; i < 2 * kScoreWindow; i += gl_WorkGroupSize.x) cells[i] = 0;
  barrier();
  const mat3 turn = camera.rotation * mat3(rotate(pose.rotation, vec3(1, 0, 0)), rotate(pose.rotation, vec3(0, 1, 0)), rotate(pose.rotation, vec3(0, 0, 1))) * pose.scale;
  for (uint i = gl_LocalInvocationID.x; i < args.point_count; i += gl_WorkGroupSize.x) {
    const Projection projection = projectThroughLens(camera, center + turn * args.points.at[i]);
    const ivec2 cell = ivec2(floor((projection.pixel + 0.5) / cell_pixels)) - origin;
    if (projection.valid && all(greaterThanEqual(cell, ivec2(0))) && all(lessThan(cell, ivec2(kScoreWindow))))
      atomicOr(cells[2 * cell.y + (cell.x >> 5)], 1u << (cell.x & 31));
  }
  // the forearm
  const vec3 from = center + turn * args.frame.at[0].arm_from;
  vec3 to = center + turn * args.frame.at[0].arm_to;
  if (to.z < kNearest) to = mix(from, to, max(0, (kNearest - from.z) / (to.z - from.z)));
  const vec2 arm = projectThroughLens(camera, from).pixel, along = projectThroughLens(camera, to).pixel - arm;
  const float radius = camera.focal.x * pose.scale * args.frame.at[0].arm_radius / max(kNearest, from.z);
  barrier();

  for (uint y = gl_LocalInvocationID.x; y < kScoreWindow; y += gl_WorkGroupSize.x) {
    const uint64_t own = rowOf(int(y));
    uint64_t near = 0ul;
    for (int dy = -int(kScoreMargin); dy <= int(kScoreMargin); ++dy) near |= rowOf(int(y) + dy);
    for (uint dx = 0; dx < kScoreMargin; ++dx) near |= near << 1 | near >> 1;
    float difference = 0;
    uint count = 0;
    for (uint half_ = 0; half_ < 2; ++half_) {
      const uint own_bits = unpackUint2x32(own)[half_];
      for (uint rest = unpackUint2x32(near)[half_]; rest != 0; rest &= rest - 1) {
        const uint bit = findLSB(rest);
        const ivec2 cell = origin + ivec2(32 * half_ + bit, y);
        const float hand = float(own_bits >> bit & 1u);
        const vec2 pixel = (vec2(cell) + 0.5) * cell_pixels - 0.5;
        const float probability = probabilityAt(tiles, ivec2(floor((pixel + 0.5) / float(kBlockPixels))));
        if (probability < 0) continue;
        count += uint(hand);
        const vec2 offset = pixel - arm;
        if (length(offset - clamp(dot(offset, along) / max(dot(along, along), 1e-9), 0, 1) * along) < radius) continue;
        difference += (hand - probability) * (hand - probability);
      }
    }
    differences[y] = difference;
    counts[y] = count;
  }
  barrier();
  if (gl_LocalInvocationID.x != 0) return;
  float difference = 0;
  uint count = 0;
  for (uint y = 0; y < kScoreWindow; ++y) {
    difference += differences[y];
    count += counts[y];
  }
  args.scores.at[gl_WorkGroupID.x * args.camera_count + index] = center.z > kNearest && count >= kScoreLeast ? difference / float(count) : -1;
}
