#version 460
// SPDX-License-Identifier: MIT
// A seamless backdrop, darker towards the picture's corners, and the shadow that falls on the ground.
#extension GL_GOOGLE_include_directive : require
#include "shaders/renderer_io.h"

layout(push_constant, scalar) uniform Push { RenderBackdropArgs args; };
layout(location = 0) out vec4 color;

vec2 groundLight(vec2 place) {
  const float cells = kGroundCells - 1;
  const vec2 at = clamp((place / args.ground_half * 0.5 + 0.5) * cells, 0, cells - 0.001);
  const uvec2 cell = uvec2(at);
  const vec2 f = at - vec2(cell);
  const uint first = cell.x + kGroundCells * cell.y;
  const vec2 low = mix(args.ground_lights.at[first].xy, args.ground_lights.at[first + 1].xy, f.x);
  const vec2 high =
      mix(args.ground_lights.at[first + kGroundCells].xy, args.ground_lights.at[first + kGroundCells + 1].xy, f.x);
  return mix(low, high, f.y);
}

// Of one pixel, from 0 to 1: breaks up the steps of 8 bits.
float grain(uvec2 pixel) {
  uint h = pixel.x * 0x9E3779B1u ^ pixel.y * 0x85EBCA77u;
  h = (h ^ h >> 15) * 0x2C1B3C6Du;
  h = (h ^ h >> 12) * 0x297A2D39u;
  return float((h ^ h >> 15) >> 8) / 16777216.0;
}

void main() {
  const vec2 size = args.viewport;
  const vec2 at = gl_FragCoord.xy / size;
  const vec2 from_middle = (at - vec2(0.45, 0.42)) * vec2(min(size.x / size.y, 1.6), 1);
  vec3 light = mix(args.top, args.bottom, smoothstep(0.0, 1.0, at.y));
  light *= 1.04 - 0.30 * dot(from_middle, from_middle);

  const vec3 ray = args.ray_corner + gl_FragCoord.x * args.ray_right +
                   gl_FragCoord.y * args.ray_down;
  const float below = args.ground_z - args.eye.z;
  if (uint64_t(args.ground_lights) != 0 && ray.z < 0 && below < 0) {
    const vec2 place = args.eye.xy + ray.xy * (below / ray.z);
    const vec2 border = abs(place) / args.ground_half;
    const float edge = max(border.x, border.y);
    if (edge < 1) {
      const vec2 ground = mix(groundLight(place), vec2(1), smoothstep(0.75, 1.0, edge));
      const vec3 shade = vec3(0.50, 0.475, 0.47) + vec3(0.50, 0.525, 0.53) * ground.x;  // warm in the shade
      light *= shade * (0.25 + 0.75 * ground.y);
    }
  }
  light += (grain(uvec2(gl_FragCoord.xy)) - 0.5) * sqrt(light) * (1.6 / 255);
  color = vec4(light, 1);
}
