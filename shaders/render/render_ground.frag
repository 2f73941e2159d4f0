#version 460
// SPDX-License-Identifier: MIT
// See render_ground.vert.
#extension GL_GOOGLE_include_directive : require
#include "shaders/render/render_backdrop.glsl"
#include "shaders/render/renderer_io.h"

layout(push_constant, scalar) uniform Push { RenderBackdropArgs args; };
layout(location = 0) in vec3 shade;
layout(location = 0) out vec4 color;

void main() { color = vec4(backdrop(gl_FragCoord.xy, args.viewport, args.top, args.bottom, shade), 1); }
