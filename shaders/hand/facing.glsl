// SPDX-License-Identifier: MIT
// Which side of a projected triangle a camera sees.

// Whether the corners, counterclockwise from outside the hand, face the camera. The image's y points down.
bool isFront(vec2 a, vec2 b, vec2 c) {
  const vec2 p = b - a, q = c - a;
  return p.x * q.y - p.y * q.x < 0;
}
