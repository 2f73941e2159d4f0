#version 460
// SPDX-License-Identifier: MIT
// A voxel's face, with darker edges, so that voxels are distinguishable.
#extension GL_GOOGLE_include_directive : require
#include "shaders/render/renderer_voxels_io.h"
#include "shaders/render/render_studio.glsl"

layout(push_constant, scalar) uniform Push { RenderVoxelArgs args; };
layout(location = 0) in vec3 to_eye;
layout(location = 1) flat in vec3 normal;
layout(location = 2) flat in vec2 light;
layout(location = 3) in vec2 in_face;
layout(location = 0) out vec4 color;

void main() {
  const float edge = max(abs(in_face.x), abs(in_face.y));
  const float width = fwidth(edge);
  // lines thinner than a pixel fade instead of flickering
  const float line = smoothstep(0.86 - width, 0.94, edge) * clamp(0.25 / max(width, 1e-3), 0, 1);
  const Material matter = Material(args.albedo * (1 - 0.42 * line), 0.15, 0.05, 20, 0.1);
  color = vec4(exposed(studio(matter, normal, normal.z, normalize(to_eye), args.key_direction, light.x, light.y)), 1);
}
