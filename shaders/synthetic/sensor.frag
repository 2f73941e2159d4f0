#version 460
// SPDX-License-Identifier: MIT
// Skin in a studio: a soft key light with a red terminator, light from above and below, a faint gloss.
#extension GL_GOOGLE_include_directive : require
#include "shaders/synthetic/sensor_io.h"
#include "shaders/synthetic/noise.glsl"

layout(push_constant, scalar) uniform Push { SensorMeshArgs args; };
layout(location = 0) in vec3 place_in_hand;
layout(location = 1) in vec4 normal_in_hand;
layout(location = 2) in float blotch;  // 0 pale to 1 red
layout(location = 0) out vec4 color;

const vec3 kSkin = vec3(0.52, 0.25, 0.165);            // linear
const vec3 kBleed = vec3(0.45, 0.22, 0.15);            // how far past the terminator light reaches in skin, per channel
const vec3 kKey = vec3(1.00, 0.95, 0.88);
const vec3 kSky = vec3(0.34, 0.36, 0.40), kGround = vec3(0.07, 0.09, 0.10);
const float kGloss = 0.05, kGlossSharpness = 24;

void main() {
  const vec3 n = normalize(normal_in_hand.xyz);
  const float open = normal_in_hand.w;
  const vec3 eye_in_hand = -args.hand_in_camera * args.camera_from_hand;  // the inverse rotation is the transpose
  const vec3 to_eye = normalize(eye_in_hand - place_in_hand);

  vec3 albedo = kSkin * mix(vec3(1.06, 1.05, 1.05), vec3(0.96, 0.82, 0.80), blotch);
  albedo *= 0.96 + 0.08 * valueNoise(420 * place_in_hand);

  const vec3 key = max((dot(n, args.key_in_hand) + kBleed) / (1 + kBleed), 0);
  const vec3 around = mix(kGround, kSky, 0.5 + 0.5 * dot(n, args.up_in_hand));
  vec3 light = albedo * (kKey * key * key * mix(0.6, 1.0, open) + around * open);
  const vec3 half_way = normalize(args.key_in_hand + to_eye);
  light += kGloss * pow(max(dot(n, half_way), 0), kGlossSharpness) * open;
  light += 0.06 * kSky * pow(1 - max(dot(n, to_eye), 0), 4) * open;
  color = vec4(light, 1);
}
