// SPDX-License-Identifier: MIT
// A seamless backdrop, darker towards the image's corners.

// Noise for one pixel, from 0 to 1: hides 8-bit banding.
float grain(uvec2 pixel) {
  uint h = pixel.x * 0x9E3779B1u ^ pixel.y * 0x85EBCA77u;
  h = (h ^ h >> 15) * 0x2C1B3C6Du;
  return float((h ^ h >> 14) >> 8) / 16777216.0;
}

// `shade` is the light that remains in shadow. Linear light.
vec3 backdrop(vec2 pixel, vec2 viewport, vec3 top, vec3 bottom, vec3 shade) {
  const vec2 at = pixel / viewport;
  const vec2 from_middle = (at - vec2(0.45, 0.42)) * vec2(min(viewport.x / viewport.y, 1.6), 1);
  const float down = at.y * at.y * (3 - 2 * at.y);
  const vec3 light = mix(top, bottom, down) * (1.04 - 0.30 * dot(from_middle, from_middle)) * shade;
  return light * (1 + (grain(uvec2(pixel)) - 0.5) * 0.007);
}
