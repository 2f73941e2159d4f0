#version 460
// SPDX-License-Identifier: MIT
// Lists a camera's silhouette edges in their order. One subgroup per camera.
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "shaders/hand/facing.glsl"
#include "shaders/hand/outline_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { OutlineListArgs args; };

bool isSilhouette(uint edge) {
  const GpuOutlineEdge corners = args.edges.at[edge];
  const uint first = gl_WorkGroupID.x * args.vertex_count;
  const vec2 from = args.pixels.at[first + corners.from], to = args.pixels.at[first + corners.to];
  const vec2 left = args.pixels.at[first + corners.left], right = args.pixels.at[first + corners.right];
  if (min(min(from.x, to.x), min(left.x, right.x)) <= kNotProjected) return false;
  return isFront(from, to, left) != isFront(to, from, right) && length(to - from) >= kShortestEdge;
}

void main() {
  const uint list = gl_WorkGroupID.x * kOutlineList;
  uint count = 0;
  if ((args.frame.at[0].cameras >> gl_WorkGroupID.x & 1u) != 0)
    for (uint first = 0; first < args.edge_count; first += gl_WorkGroupSize.x) {
      const uint edge = first + gl_LocalInvocationID.x;
      uint found = 0;
      if (edge < args.edge_count) found = uint(isSilhouette(edge));
      const uint total = subgroupAdd(found);
      if (total == 0) continue;
      const uint at = count + subgroupExclusiveAdd(found);
      if (found != 0 && at < kOutlineLines) args.lists.at[list + 1 + at] = edge;
      count += total;
    }
  if (gl_LocalInvocationID.x == 0) args.lists.at[list] = min(count, kOutlineLines);
}
