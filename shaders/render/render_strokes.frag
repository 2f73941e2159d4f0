#version 460
// SPDX-License-Identifier: MIT
// Pixel coverage of a stroke with round ends.
#extension GL_GOOGLE_include_directive : require
#include "shaders/render/renderer_io.h"

layout(push_constant, scalar) uniform Push { RenderStrokeArgs args; };
layout(location = 0) noperspective in vec2 along_across;
layout(location = 1) flat in float segment_length;
layout(location = 0) out vec4 color;

void main() {
  const float beyond = along_across.x - clamp(along_across.x, 0, segment_length);
  const float from_middle = length(vec2(beyond, along_across.y));
  const float cover = clamp(0.5 * args.width + 0.5 - from_middle, 0, 1);
  if (cover == 0) discard;
  color = vec4(args.color.rgb, args.color.a * cover);
}
