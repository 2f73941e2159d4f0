#version 460
// SPDX-License-Identifier: MIT
// A voxel's cube: the three faces that point towards the eye.
#extension GL_GOOGLE_include_directive : require
#include "shaders/render/renderer_voxels_io.h"

layout(push_constant, scalar) uniform Push { RenderVoxelArgs args; };
layout(location = 0) out vec3 to_eye;
layout(location = 1) flat out vec3 normal;
layout(location = 2) flat out vec2 light;
layout(location = 3) out vec2 in_face;  // -1 to 1

void main() {
  const vec3 center = args.positions.at[gl_InstanceIndex];
  const vec3 towards = args.eye - center;
  const uint axis = gl_VertexIndex / 6, corner = gl_VertexIndex % 6;
  in_face = vec2(corner == 1 || corner == 2 || corner == 4 ? 1 : -1, corner == 2 || corner == 4 || corner == 5 ? 1 : -1);
  normal = vec3(0);
  vec3 offset;
  normal[axis] = towards[axis] < 0 ? -1 : 1;
  offset[axis] = normal[axis];
  offset[(axis + 1) % 3] = in_face.x;
  offset[(axis + 2) % 3] = in_face.y;
  const vec3 place = center + 0.5 * args.voxel_m * offset;
  light = uint64_t(args.lights) == 0
              ? vec2(1)
              : vec2(args.lights.at[gl_InstanceIndex].key, args.lights.at[gl_InstanceIndex].open_front);
  to_eye = args.eye - place;
  gl_Position = args.clip_from_workspace * vec4(place, 1);
}
