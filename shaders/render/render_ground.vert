#version 460
// SPDX-License-Identifier: MIT
// The ground near the workspace: the backdrop again, with the shadows that fall on it. It is behind everything, so that what is below it
// stays visible.
#extension GL_GOOGLE_include_directive : require
#include "shaders/render/renderer_io.h"

layout(push_constant, scalar) uniform Push { RenderBackdropArgs args; };
layout(location = 0) out vec3 shade;

void main() {
  const vec3 place = args.positions.at[gl_VertexIndex];
  const vec2 light = vec2(args.lights.at[gl_VertexIndex].key, args.lights.at[gl_VertexIndex].open_front);
  const vec2 border = abs(place.xy);
  const vec2 fades = mix(light, vec2(1), smoothstep(0.6, 0.95, max(border.x, border.y)));
  // shadows are warm
  shade = (vec3(0.50, 0.475, 0.47) + vec3(0.50, 0.525, 0.53) * fades.x) * (0.35 + 0.65 * fades.y);
  gl_Position = args.clip_from_ground * vec4(place, 1);
  gl_Position.z = 0.9999 * gl_Position.w;
}
