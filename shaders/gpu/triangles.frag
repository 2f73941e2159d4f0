#version 460
// SPDX-License-Identifier: MIT
// See triangles_io.h.
#extension GL_GOOGLE_include_directive : require
#include "shaders/gpu/triangles_io.h"

layout(push_constant, scalar) uniform Push { TrianglesArgs args; };
layout(constant_id = 0) const uint kRedOnly = 0;
layout(location = 0) out vec4 color;

void main() {
  color = kRedOnly == 0 ? args.color : vec4(args.color.r, 0, 0, args.color.a);
}
