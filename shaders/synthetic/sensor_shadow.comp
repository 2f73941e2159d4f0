#version 460
// SPDX-License-Identifier: MIT
// A large light's shadow of the hand on the floor: every spot of the skin darkens what is behind it, more softly from higher up.
#extension GL_GOOGLE_include_directive : require
#include "shaders/synthetic/sensor_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { ShadowArgs args; };

const float kStrength = 0.45;  // the fraction of the light that the hand can block
const float kSoftness = 0.09;  // metres of blur per metre of height

void main() {
  const uint cell = gl_GlobalInvocationID.x;
  if (cell >= kShadowCells * kShadowCells) return;
  const vec2 at = (2 * (vec2(cell % kShadowCells, cell / kShadowCells) + 0.5) / float(kShadowCells) - 1) *
                  kShadowHalf * args.edge_m;
  float depth = 0;
  for (uint i = 0; i < args.spot_count; ++i) {
    const vec3 p = args.workspace_from_hand * args.spots.at[i] + args.hand_in_workspace;
    const float height = max(p.z - args.floor_z, 0);
    const vec2 off = at - (p.xy - args.key_slope * height);
    const float blur = 0.04 * args.edge_m + kSoftness * height;
    depth += args.spot_weight * exp(-0.5 * dot(off, off) / (blur * blur));
  }
  const float light = 1 - kStrength * (1 - exp(-depth));
  args.shadow.at[cell] = pow(light, 1 / 2.2);  // approximates the sRGB curve
}
