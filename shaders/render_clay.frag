#version 460
// SPDX-License-Identifier: MIT
// Clay: matt, a little waxy, lit from both sides where the surface is open.
#extension GL_GOOGLE_include_directive : require
#include "shaders/render_studio.glsl"
#include "shaders/renderer_io.h"

layout(push_constant, scalar) uniform Push { RenderMeshArgs args; };
layout(location = 0) in vec3 normal;
layout(location = 1) in vec3 to_eye;
layout(location = 2) in vec4 light;
layout(location = 0) out vec4 color;

void main() {
  const float side = gl_FrontFacing ? 1 : -1;
  const Material clay = Material(args.albedo, 0.12, 0.06, 22, 0.2);
  const vec3 leaving = studio(clay, side * normalize(normal), side * light.w, normalize(to_eye), args.key_direction,
                              light.x, gl_FrontFacing ? light.y : light.z);
  color = vec4(exposed(leaving), 1);
}
