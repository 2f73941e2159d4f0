#version 460
// SPDX-License-Identifier: MIT
// A vertex of a lit mesh. Specialization constant 0: 1 for the forearm, which fades away from the wrist (the hand's origin).
#extension GL_GOOGLE_include_directive : require
#include "shaders/render/renderer_io.h"

layout(constant_id = 0) const uint kFades = 0;
layout(push_constant, scalar) uniform Push { RenderMeshArgs args; };
invariant gl_Position;  // must give the same depth as the preceding depth pass (render_depth.vert)
layout(location = 0) out vec3 normal;  // mesh frame
layout(location = 1) out vec3 to_eye;  // mesh frame
layout(location = 2) out vec4 light;   // key, open to the front and behind, upward: VertexLight
layout(location = 3) out float opacity;
layout(location = 4) out float hand_m;

void main() {
  const vec3 place = args.positions.at[gl_VertexIndex];
  normal = args.normals.at[gl_VertexIndex];
  to_eye = args.eye - place;
  const VertexLight arrives = args.lights.at[gl_VertexIndex];
  light = vec4(arrives.key, arrives.open_front, arrives.open_behind, arrives.upward);
  hand_m = arrives.hand_m;
  opacity = kFades == 1 ? args.opacity * (1 - smoothstep(0.03, 0.17, length(place))) : args.opacity;
  gl_Position = args.clip_from_mesh * vec4(place, 1);
}
