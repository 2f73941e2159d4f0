#version 460
// SPDX-License-Identifier: MIT
// See triangles_io.h.
#extension GL_GOOGLE_include_directive : require
#include "shaders/gpu/triangles_io.h"

layout(push_constant, scalar) uniform Push { TrianglesArgs args; };

void main() {
  gl_Position = vec4(args.corners.at[gl_VertexIndex], 1);
}
