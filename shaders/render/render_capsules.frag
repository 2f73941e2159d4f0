#version 460
// SPDX-License-Identifier: MIT
// Links, joints and arrows: smooth and evenly lit.
#extension GL_GOOGLE_include_directive : require
#include "shaders/render/render_studio.glsl"
#include "shaders/render/renderer_io.h"

layout(push_constant, scalar) uniform Push { RenderCapsuleArgs args; };
layout(location = 0) in vec3 normal;
layout(location = 1) in vec3 to_eye;
layout(location = 2) flat in vec3 albedo;
layout(location = 0) out vec4 color;

void main() {
  const vec3 n = normalize(normal);
  const Material ivory = Material(albedo, 0.2, 0.12, 30, 0.25);
  color = vec4(exposed(studio(ivory, n, n.z, normalize(to_eye), args.key_direction, 0.9, 0.9)), 1);
}
