#version 460
// SPDX-License-Identifier: MIT
// A vertex of a capsule: half a sphere at either end, joined.
#extension GL_GOOGLE_include_directive : require
#include "shaders/render/renderer_io.h"

layout(push_constant, scalar) uniform Push { RenderCapsuleArgs args; };
layout(location = 0) out vec3 normal;
layout(location = 1) out vec3 to_eye;
layout(location = 2) flat out vec3 albedo;

void main() {
  const RenderCapsule capsule = args.capsules.at[gl_InstanceIndex];
  const uint quad = gl_VertexIndex / 6, corner = gl_VertexIndex % 6;
  const uint next_side = corner == 1 || corner == 2 || corner == 4 ? 1 : 0;
  const uint next_ring = corner == 2 || corner == 4 || corner == 5 ? 1 : 0;
  const uint side = (quad % kCapsuleSides + next_side) % kCapsuleSides;
  const uint ring = quad / kCapsuleSides + next_ring;

  const vec3 link = capsule.b - capsule.a;
  const vec3 axis = length(link) > 1e-9 ? normalize(link) : vec3(0, 0, 1);
  const vec3 u = normalize(cross(axis, abs(axis.z) < 0.9 ? vec3(0, 0, 1) : vec3(1, 0, 0))), v = cross(axis, u);
  const uint half_rings = kCapsuleRings / 2;
  const bool at_a = ring < half_rings;
  const float steps = half_rings - 1;
  const float latitude = 1.5707963 * (at_a ? ring / steps - 1 : (ring - half_rings) / steps);
  const float longitude = 6.2831853 * side / kCapsuleSides;
  normal = cos(latitude) * (cos(longitude) * u + sin(longitude) * v) + sin(latitude) * axis;
  const vec3 place = at_a ? capsule.a + capsule.radius_a * normal : capsule.b + capsule.radius_b * normal;
  // the side of a cone is inclined
  const float lean = capsule.radius_a - capsule.radius_b;
  if (length(link) > abs(lean)) normal = normalize(normal + cos(latitude) * (lean / length(link)) * axis);
  albedo = capsule.albedo;
  to_eye = args.eye - place;
  gl_Position = args.clip_from_workspace * vec4(place, 1);
}
