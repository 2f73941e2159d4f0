#version 460
// SPDX-License-Identifier: MIT
// The hand: translucent skin, clearest where it faces the eye.
#extension GL_GOOGLE_include_directive : require
#include "shaders/render/render_studio.glsl"
#include "shaders/render/renderer_io.h"

layout(push_constant, scalar) uniform Push { RenderMeshArgs args; };
layout(location = 0) in vec3 normal;
layout(location = 1) in vec3 to_eye;
layout(location = 2) in vec4 light;
layout(location = 3) in float opacity;
layout(location = 0) out vec4 color;

void main() {
  const vec3 n = normalize(normal), eye = normalize(to_eye);
  const Material skin = Material(args.albedo, 0.35, 0.06, 26, 0.3);
  const vec3 leaving = exposed(studio(skin, n, light.w, eye, args.key_direction, light.x, light.y));
  // a layer with `opacity` seen straight on is denser when seen at an angle
  const float slant = 1 / max(abs(dot(n, eye)), 0.12);
  color = vec4(leaving, 1 - pow(1 - opacity, slant));
}
