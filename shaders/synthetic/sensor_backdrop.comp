#version 460
// SPDX-License-Identifier: MIT
// What the synthetic cameras see behind the hand: a mottled cloth, swept from the floor up into a wall. Runs once per camera.
#extension GL_GOOGLE_include_directive : require
#include "shaders/synthetic/sensor_io.h"
#include "shaders/synthetic/noise.glsl"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { BackdropArgs args; };

const float kFillet = 0.35;  // fraction of the wall's radius: radius of the transition from floor to wall
const int kSteps = 96;       // grazing rays need many
const vec3 kCloth = vec3(0.052, 0.098, 0.112);  // linear: a blue-grey green, far from skin in hue

// Bilinear interpolation of the given rays.
vec3 rayThrough(uvec2 pixel) {
  const uint across = (args.width + kRayStep - 1) / kRayStep + 1;
  const uvec2 cell = pixel / kRayStep;
  const vec2 t = vec2(pixel % kRayStep) / float(kRayStep);
  const uint at = cell.y * across + cell.x;
  return mix(mix(args.rays.at[at], args.rays.at[at + 1], t.x),
             mix(args.rays.at[at + across], args.rays.at[at + across + 1], t.x), t.y);
}

// Distance to the sweep from a point inside it: a rounded box in radius and height.
float distanceToSweep(vec3 p) {
  const float fillet = kFillet * args.wall_radius;
  const vec2 q = vec2(length(p.xy) - (args.wall_radius - fillet), args.floor_z + fillet - p.z);
  return fillet - length(max(q, 0)) - min(max(q.x, q.y), 0);
}

vec3 clothAt(vec3 p) {
  const vec3 scaled = p / args.edge_m;
  const float mottle = fractalNoise(1.9 * scaled + 5.0, 5), tint = fractalNoise(1.1 * scaled + 40.0, 3);
  const float weave = valueNoise(55 * scaled);
  vec3 cloth = kCloth * mix(vec3(1.12, 1.0, 0.86), vec3(0.86, 1.0, 1.16), smoothstep(0.25, 0.75, tint));
  cloth *= 0.45 + 1.1 * smoothstep(0.1, 0.9, mottle) + 0.07 * (weave - 0.5);
  // the light pool on the floor, and the wall darkening upwards
  const float radius = length(scaled.xy), height = (p.z - args.floor_z) / args.edge_m;
  return cloth * (0.5 + 0.75 * exp(-radius * radius / 4)) * (0.35 + 0.65 * exp(-0.35 * max(height, 0)));
}

// IEC 61966-2-1
vec3 srgbFromLinear(vec3 c) {
  return mix(c * 12.92, 1.055 * pow(c, vec3(1 / 2.4)) - 0.055, greaterThan(c, vec3(0.0031308)));
}

void main() {
  const uint index = args.first_pixel + gl_GlobalInvocationID.x;
  const uvec2 pixel = uvec2(index % args.width, index / args.width);
  if (pixel.y >= args.height) return;
  vec3 color = vec3(0);
  vec2 shadow_at = vec2(0);
  const vec3 ray = rayThrough(pixel);
  if (dot(ray, ray) > 0.5) {  // elsewhere no light arrives: a fisheye's black border
    const vec3 direction = args.workspace_from_camera * normalize(ray);
    vec3 p = args.eye;
    for (int i = 0; i < kSteps; ++i) p += distanceToSweep(p) * direction;
    const float vignette = pow(clamp(ray.z / length(ray), 0, 1), 2.5);
    color = srgbFromLinear(clothAt(p) * vignette);
    const vec2 on_floor = p.xy - args.key_slope * (p.z - args.floor_z);
    shadow_at = 0.5 + 0.5 * on_floor / (kShadowHalf * args.edge_m) - 0.5 / float(kShadowCells);  // cells' centres
  }
  const uvec3 steps = uvec3(clamp(color, 0, 1) * vec3(2047, 2047, 1023) + 0.5);
  const uint at = args.pixels_before + index;
  args.backdrop.at[at] = steps.r | steps.g << 11 | steps.b << 22;
  args.backdrop.at[args.all_pixels + at] = packUnorm2x16(clamp(shadow_at, 0, 1));
}
