#version 460
// SPDX-License-Identifier: MIT
// The light that arrives at each vertex. The key light's shadow softens with the distance of the occluder (Fernando 2005,
// "Percentage-Closer Soft Shadows"); openness to ambient light comes from a wide cone along the normal through a pyramid of surface
// densities (after Crassin et al. 2011, "Interactive Indirect Illumination Using Voxel Cone Tracing"); near the hand, the signed distance
// to its skin darkens the surfaces that face it, so that the gap is visible.
#extension GL_GOOGLE_include_directive : require
#include "shaders/render/renderer_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { RenderLightArgs args; };

const float kLightSpread = 0.16;     // the key light's radius per metre of distance: a soft box
const float kSearchM = 0.045;        // search radius for occluders
const float kLeastBlurM = 0.004;     // anything finer than the clay's vertex spacing would flicker
const float kContactM = 0.010;       // the contact shadow fades to 1/e over this gap
const float kContactDepth = 0.55;
const float kThroughSkin = 0.4;       // fraction of the key light that passes through the hand; otherwise its shadow would hide what it shapes,
const float kThroughM = 0.05;         // to 1/e over this distance
const float kConeCells = 1.6;        // beyond the cells of a flat surface itself
const float kConeStrength = 0.75;
const float kReach = 0.4;             // cosine; no material wraps light farther (render_studio.glsl)
const float kBiasM = 0.0025, kGrazingBiasM = 0.02;
const float kGoldenAngle = 2.3999632;

// Evenly distributed in the unit disc (Vogel 1979).
vec2 spiral(uint i, uint count) {
  const float r = sqrt((i + 0.5) / count), angle = i * kGoldenAngle;
  return r * vec2(cos(angle), sin(angle));
}

// The fraction of the key light that arrives; n faces it.
float keyArrives(vec3 p, vec3 n, vec3 key) {
  const vec4 row_x = args.frame.at[0].light_row[0], row_y = args.frame.at[0].light_row[1],
             row_z = args.frame.at[0].light_row[2];
  const uint size = args.frame.at[0].shadow_size;
  const float texel_m = args.frame.at[0].shadow_texel_m, depth_m = args.frame.at[0].shadow_depth_m;
  const vec4 from = vec4(p + 1.5 * texel_m * n, 1);
  const vec2 texel = (vec2(dot(row_x, from), dot(row_y, from)) * 0.5 + 0.5) * size;
  const float depth = dot(row_z, from);
  // the receiver's own plane, in depth per texel: a wide kernel must not find the receiver itself
  const vec2 normal = vec2(dot(row_x.xyz, n), dot(row_y.xyz, n));
  const float towards = dot(n, key), facing = max(towards, 0.15);
  const vec2 slope =
      normal / max(length(normal), 1e-6) * (sqrt(max(1 - facing * facing, 0)) / facing * texel_m / depth_m);
  // at grazing angles the surface's own nearby parts would shade it in patches; the cosine shades it enough
  const float bias = mix(kGrazingBiasM, kBiasM, smoothstep(0.0, 0.4, towards)) / depth_m;

  const uint taps = args.frame.at[0].shadow_taps;
  float gap_sum = 0;
  uint blockers = 0;
  for (uint i = 0; i < taps; ++i) {
    const vec2 offset = spiral(i, taps) * (kSearchM / texel_m);
    const ivec2 at = clamp(ivec2(texel + offset), ivec2(0), ivec2(size - 1));
    const float gap = depth + dot(slope, offset) - bias - args.shadow_map.at[at.x + at.y * int(size)];
    if (gap > 0) {
      gap_sum += gap * depth_m;
      ++blockers;
    }
  }
  if (blockers == 0) return 1;
  const float radius = clamp(kLightSpread * gap_sum / blockers, kLeastBlurM, kSearchM) / texel_m;
  float lit = 0;
  for (uint i = 0; i < taps; ++i) {
    const vec2 offset = spiral(i, taps) * radius;
    const ivec2 at = clamp(ivec2(texel + offset), ivec2(0), ivec2(size - 1));
    lit += clamp(1 + (args.shadow_map.at[at.x + at.y * int(size)] - depth - dot(slope, offset)) / bias, 0, 1);
  }
  return lit / taps;
}

// Interpolates between the cells' centres; the density outside the pyramid is 0.
float density(vec3 unit, uint level) {
  const uint edge = kDensityCells >> level;
  const uint first = level == 0 ? 0 : level == 1 ? 32 * 32 * 32 : 32 * 32 * 32 + 16 * 16 * 16;
  const vec3 at = unit * edge - 0.5;
  const ivec3 cell = ivec3(floor(at));
  const vec3 f = at - vec3(cell);
  if (any(lessThan(cell, ivec3(-1))) || any(greaterThanEqual(cell, ivec3(edge)))) return 0;
  float sum = 0;
  for (int i = 0; i < 8; ++i) {
    const ivec3 side = ivec3(i & 1, i >> 1 & 1, i >> 2), c = cell + side;
    if (any(lessThan(c, ivec3(0))) || any(greaterThanEqual(c, ivec3(edge)))) continue;
    const vec3 weight = mix(1 - f, f, vec3(side));
    sum += weight.x * weight.y * weight.z * args.densities.at[first + c.x + edge * (c.y + edge * c.z)];
  }
  return sum;
}

// The unoccluded fraction of a wide cone along n.
float openness(vec3 p, vec3 n, float edge_m) {
  const vec3 unit = p / edge_m + 0.5;
  float hidden = 0;
  for (uint level = 0; level < kDensityLevels; ++level) {
    const float away = kConeCells * (1 << level) / kDensityCells;  // in edge lengths: this many cells of this level
    hidden += density(unit + away * n, level);
  }
  return exp(-kConeStrength * hidden);
}

// The hand's signed distance and, in yzw, its gradient in the workspace frame.
vec4 handDistance(vec3 p) {
  const mat3 hand_from_workspace = args.frame.at[0].hand_from_workspace;
  const vec3 in_hand = hand_from_workspace * p + args.frame.at[0].workspace_in_hand;
  const uvec3 size =
      uvec3(args.frame.at[0].grid_size[0], args.frame.at[0].grid_size[1], args.frame.at[0].grid_size[2]);
  const float cell_m = args.frame.at[0].grid_cell_m;
  const vec3 free = (in_hand - args.frame.at[0].grid_low_corner) / cell_m;
  const vec3 at = clamp(free, vec3(0), vec3(size - 1) - 0.001);
  const uvec3 cell = uvec3(at);
  const vec3 f = at - vec3(cell);
  const float outside = length(free - at) * cell_m;
  if (outside > 4 * kContactM) return vec4(outside, 0, 0, 0);
  float v[8];
  for (uint i = 0; i < 8; ++i) {
    const uvec3 c = cell + uvec3(i & 1, i >> 1 & 1, i >> 2);
    v[i] = args.hand_grid.at[c.x + size.x * (c.y + size.y * c.z)];
  }
  const vec4 x = mix(vec4(v[0], v[2], v[4], v[6]), vec4(v[1], v[3], v[5], v[7]), f.x);
  const vec2 y = mix(x.xz, x.yw, f.y);
  const vec4 dx = vec4(v[1] - v[0], v[3] - v[2], v[5] - v[4], v[7] - v[6]);
  const vec2 dxy = mix(dx.xz, dx.yw, f.y);
  const vec2 dy = x.yw - x.xz;
  const vec3 gradient = vec3(mix(dxy.x, dxy.y, f.z), mix(dy.x, dy.y, f.z), y.y - y.x) / cell_m;
  return vec4(mix(y.x, y.y, f.z) + outside, gradient * hand_from_workspace);
}

void main() {
  const uint vertex = gl_GlobalInvocationID.x;
  const bool counted = uint64_t(args.device_count) != 0;
  if (vertex >= (counted ? min(args.count, args.device_count.at[0]) : args.count)) return;
  const vec3 p = args.rotation * args.positions.at[vertex] + args.translation;
  const vec3 n = normalize(args.rotation * args.normals.at[vertex]);
  const vec3 key = args.frame.at[0].key_direction;
  const float edge_m = args.frame.at[0].edge_m;
  const bool faces_key = dot(n, key) >= 0;
  // soft materials take some light from beyond the terminator, never past kReach
  const bool reached = args.two_sided == 1 || dot(n, key) > -kReach;
  float arrives = reached ? keyArrives(p, faces_key || args.two_sided == 0 ? n : -n, key) : 0.0;
  vec2 open = vec2(openness(p, n, edge_m), args.two_sided == 1 ? openness(p, -n, edge_m) : 1.0);
  float hand_m = kFarM;
  if (uint64_t(args.hand_grid) != 0) {
    const vec4 hand = handDistance(p);
    const float faces_hand = -dot(n, hand.yzw);
    const vec2 sees = smoothstep(vec2(-0.4), vec2(0.6), vec2(faces_hand, -faces_hand));
    const vec2 contact = 1 - kContactDepth * exp(-max(hand.x, 0) / kContactM) * sees;
    open *= contact;
    arrives *= faces_key ? contact.x : contact.y;
    if (reached) arrives = max(arrives, kThroughSkin * exp(-max(hand.x, 0) / kThroughM));
    if (args.shows_touch == 1) hand_m = hand.x;
  }
  args.lights.at[vertex] = VertexLight(arrives, open.x, open.y, n.z, hand_m);
}
