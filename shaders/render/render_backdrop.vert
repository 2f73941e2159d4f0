#version 460
// SPDX-License-Identifier: MIT
// One triangle that covers the image, behind everything.

void main() {
  const vec2 corner = vec2(gl_VertexIndex == 1 ? 3 : -1, gl_VertexIndex == 2 ? 3 : -1);
  gl_Position = vec4(corner, 1, 1);
}
