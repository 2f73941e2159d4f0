#version 460
// SPDX-License-Identifier: MIT
// Clay: matt, a little waxy, lit from both sides where the surface is open; warm in colour where the hand touches it.
#extension GL_GOOGLE_include_directive : require
#include "shaders/render/render_studio.glsl"
#include "shaders/render/renderer_io.h"

layout(push_constant, scalar) uniform Push { RenderMeshArgs args; };
layout(location = 0) in vec3 normal;
layout(location = 1) in vec3 to_eye;
layout(location = 2) in vec4 light;
layout(location = 4) in float hand_m;
layout(location = 0) out vec4 color;

const vec3 kTouchColor = vec3(0.80, 0.19, 0.045);
const float kTouchShare = 0.75;
const float kTouchM = 0.001, kNoTouchM = 0.004;  // smaller values are below the pose error; with larger ones a nearby finger would seem to touch

void main() {
  const float side = gl_FrontFacing ? 1 : -1;
  const float touch = kTouchShare * (1 - smoothstep(kTouchM, kNoTouchM, hand_m));
  const Material clay = Material(mix(args.albedo, kTouchColor, touch), 0.12, 0.06, 22, 0.2);
  const vec3 leaving = studio(clay, side * normalize(normal), side * light.w, normalize(to_eye), args.key_direction,
                              light.x, gl_FrontFacing ? light.y : light.z);
  color = vec4(exposed(leaving), 1);
}
