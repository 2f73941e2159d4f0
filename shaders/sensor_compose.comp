#version 460
// SPDX-License-Identifier: MIT
// The picture that a camera would send: hand before backdrop, Gaussian noise, BGR bytes.
#extension GL_GOOGLE_include_directive : require
#include "shaders/sensor_io.h"
#include "shaders/noise.glsl"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint kHasHand = 1;
layout(push_constant, scalar) uniform Push { ComposeArgs args; };

// Bilinear; the map's border is without shadow.
float shadowAt(uint pixel) {
  const vec2 at = unpackUnorm2x16(args.backdrop.at[2 * pixel + 1]) * float(kShadowCells);
  const vec2 inside = clamp(at, 0, float(kShadowCells) - 1.001);
  const uvec2 cell = uvec2(inside);
  const vec2 t = fract(inside);
  const uint i = cell.y * kShadowCells + cell.x;
  return mix(mix(args.shadow.at[i], args.shadow.at[i + 1], t.x),
             mix(args.shadow.at[i + kShadowCells], args.shadow.at[i + kShadowCells + 1], t.x), t.y);
}

// From 0 to 255, without noise. Light adds up in linear light, for which the squares stand here: a fourth of a power's price, and exact
// where hand or backdrop has the pixel to itself.
vec3 seenAt(uint pixel, float shadow) {
  const uint packed = args.backdrop.at[2 * pixel];
  const vec3 backdrop = vec3(packed & 2047, packed >> 11 & 2047, packed >> 22) * 255 / vec3(2047, 2047, 1023);
  if (kHasHand == 0) return backdrop;
  const uint word = args.hand.at[pixel];
  const vec3 hand = vec3(word & 255, word >> 8 & 255, word >> 16 & 255);
  const vec3 cloth = backdrop * shadow;
  return sqrt(hand * hand + cloth * cloth * (1 - float(word >> 24) / 255));
}

// 24 bits, blue lowest.
uint bgrAt(uint pixel, float shadow, uvec3 hash) {
  const uvec3 chance = hash >> (16 - kQuantileBits);
  const vec3 noise = vec3(args.quantiles.at[chance.x], args.quantiles.at[chance.y], args.quantiles.at[chance.z]);
  const uvec3 rgb = uvec3(clamp(args.brightness * seenAt(pixel, shadow) + args.noise_sigma * noise + 0.5, 0, 255));
  return rgb.b | rgb.g << 8 | rgb.r << 16;
}

void main() {
  const uint camera = gl_WorkGroupID.y;
  const uint pixels = args.cameras.at[camera].width * args.cameras.at[camera].height;
  const uint before = args.cameras.at[camera].pixels_before;
  const uint first = 4 * gl_GlobalInvocationID.x;
  if (first >= pixels) return;

  // a hash is six numbers of 16 bits: three channels of two pixels
  const uvec3 a = pcg3d(uvec3(before + first, args.frame, args.seed));
  const uvec3 b = pcg3d(uvec3(before + first + 1, args.frame, args.seed));
  const uint last = before + pixels - 1, at = before + first;
  const float shadow = kHasHand == 0 ? 1 : shadowAt(at);  // soft enough for one value
  const uint p0 = bgrAt(at, shadow, a & 0xFFFFu), p1 = bgrAt(min(at + 1, last), shadow, a >> 16);
  const uint p2 = bgrAt(min(at + 2, last), shadow, b & 0xFFFFu), p3 = bgrAt(min(at + 3, last), shadow, b >> 16);

  const uint word = args.cameras.at[camera].picture_words + 3 * gl_GlobalInvocationID.x;
  const uint words = min(3u, (3 * (pixels - first) + 3) / 4);  // of the last pixels, no word more than there is
  args.pictures.at[word] = p0 | p1 << 24;
  if (words > 1) args.pictures.at[word + 1] = p1 >> 8 | p2 << 16;
  if (words > 2) args.pictures.at[word + 2] = p2 >> 16 | p3 << 8;
}
