#version 460
// SPDX-License-Identifier: MIT
// The image that a camera would send: hand in front of backdrop, Gaussian noise, BGR bytes.
#extension GL_GOOGLE_include_directive : require
#include "shaders/synthetic/sensor_io.h"
#include "shaders/synthetic/noise.glsl"
#include "shaders/camera/image_layout.glsl"

layout(local_size_x_id = 0) in;
layout(constant_id = 3) const uint kHasHand = 1;
layout(push_constant, scalar) uniform Push { ComposeArgs args; };

// Bilinear; the map's border has no shadow.
float shadowAt(uint pixel) {
  const vec2 at = unpackUnorm2x16(args.backdrop.at[args.all_pixels + pixel]) * float(kShadowCells);
  const vec2 inside = clamp(at, 0, float(kShadowCells) - 1.001);
  const uvec2 cell = uvec2(inside);
  const vec2 t = fract(inside);
  const uint i = cell.y * kShadowCells + cell.x;
  return mix(mix(args.shadow.at[i], args.shadow.at[i + 1], t.x),
             mix(args.shadow.at[i + kShadowCells], args.shadow.at[i + kShadowCells + 1], t.x), t.y);
}

// From 0 to 255, without noise. Light adds up linearly; squares approximate linear light here, at a quarter of the cost of a power, and
// exactly where only hand or only backdrop covers the pixel.
vec3 seen(uint packed_backdrop, uint rgba, float shadow) {
  const vec3 backdrop = vec3(packed_backdrop & 2047, packed_backdrop >> 11 & 2047, packed_backdrop >> 22) * 255 / vec3(2047, 2047, 1023);
  if (kHasHand == 0) return backdrop;
  const vec3 hand = vec3(rgba & 255, rgba >> 8 & 255, rgba >> 16 & 255);
  const vec3 cloth = backdrop * shadow;
  return sqrt(hand * hand + cloth * cloth * (1 - float(rgba >> 24) / 255));
}

// 24 bits, blue lowest.
uint bgr(vec3 color, uint chance) {
  const uvec2 packed = unpackUint2x32(args.noise.at[chance & ((1u << kNoiseBits) - 1)]);
  const uvec3 steps = uvec3(packed.x, packed.x >> 21 | packed.y << 11, packed.y >> 10) & kNoiseSteps;
  const vec3 noise = kNoiseReach * (vec3(steps) * (2 / float(kNoiseSteps)) - 1);
  const uvec3 rgb = uvec3(clamp(args.brightness * color + args.noise_sigma * noise + 0.5, 0, 255));
  return rgb.b | rgb.g << 8 | rgb.r << 16;
}

// Loads words in pairs: on lavapipe, loading two costs the same as loading one.
uvec4 fourAt(uint64_t words, uint index) {
  ReadUlongs pairs = ReadUlongs(words + 4ul * index);
  return uvec4(unpackUint2x32(pairs.at[0]), unpackUint2x32(pairs.at[1]));
}

void main() {
  const ImageLayout camera = imageLayoutOf(args.cameras, args.camera);
  const uint pixels = camera.width * camera.height, first = 4 * gl_GlobalInvocationID.x;
  if (first >= pixels) return;

  const uint at = camera.pixels_before + first;
  const uvec4 backdrop = fourAt(uint64_t(args.backdrop), at);
  const uvec4 hand = kHasHand == 0 ? uvec4(0) : fourAt(uint64_t(args.hand), at);
  const float shadow = kHasHand == 0 ? 1 : shadowAt(at);  // smooth enough for one value per four pixels
  const uvec3 hash = pcg3d(uvec3(at, args.frame, args.seed));
  const uint p0 = bgr(seen(backdrop.x, hand.x, shadow), hash.x), p1 = bgr(seen(backdrop.y, hand.y, shadow), hash.x >> 16);
  const uint p2 = bgr(seen(backdrop.z, hand.z, shadow), hash.y), p3 = bgr(seen(backdrop.w, hand.w, shadow), hash.y >> 16);

  const uint word = camera.image_words + 3 * gl_GlobalInvocationID.x;
  const uint words = min(3u, (3 * (pixels - first) + 3) / 4);  // the last pixels write no word past the end
  args.images.at[word] = p0 | p1 << 24;
  if (words > 1) args.images.at[word + 1] = p1 >> 8 | p2 << 16;
  if (words > 2) args.images.at[word + 2] = p2 >> 16 | p3 << 8;
}
