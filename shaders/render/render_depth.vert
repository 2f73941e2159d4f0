#version 460
// SPDX-License-Identifier: MIT
// A mesh's depth only, as seen by the eye or the key light.
#extension GL_GOOGLE_include_directive : require
#include "shaders/render/renderer_io.h"

layout(push_constant, scalar) uniform Push { RenderMeshArgs args; };
invariant gl_Position;

void main() { gl_Position = args.clip_from_mesh * vec4(args.positions.at[gl_VertexIndex], 1); }
