#version 460
// SPDX-License-Identifier: MIT
// Finds where the object ends: a pixel between background and a score more than twice its own is the smear of an edge. 64 pixels per
// invocation.
#extension GL_GOOGLE_include_directive : require
#include "shaders/camera/image_layout.glsl"
#include "shaders/silhouette/silhouette_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { EdgeArgs args; };

const uint kBackground = 0, kFour = 1, kEight = 2;  // kinds of neighbour: a score below 1, of 4 or more, of 8 or more

// A word of the pixels of that kind; 0 outside the image.
uint64_t pixelsOf(ImageLayout camera, uint kind, uint row_start, uint pair) {
  const uint row_pairs = camera.row_words / 2;
  if (pair >= row_pairs) return 0ul;
  const uint at = kScoreLevels * (row_start + pair);
  if (kind != kBackground) return args.levels.at[at + 1 + kind];  // the levels are 1, 2, 4, 8
  const uint rest = camera.width % 64;
  const uint64_t inside = rest == 0 || pair + 1 < row_pairs ? ~0ul : (1ul << rest) - 1ul;
  return ~args.levels.at[at] & inside;
}

// Whether a score of 4 or more is within reach of any of the word's pixels.
bool isNearObject(ImageLayout camera, uint y, uint pair) {
  const uint edge = 64 - kSmearReach;
  uint64_t found = 0ul;
  for (int dy = -kSmearReach; dy <= kSmearReach; ++dy) {
    const uint row = y + uint(dy);  // wraps below 0: not less than the height
    if (row >= camera.height) continue;
    const uint row_start = camera.mask_words / 2 + row * (camera.row_words / 2);
    found |= pixelsOf(camera, kFour, row_start, pair) | pixelsOf(camera, kFour, row_start, pair - 1) >> edge |
             pixelsOf(camera, kFour, row_start, pair + 1) << edge;
  }
  return found != 0ul;
}

void main() {
  const ImageLayout camera = imageLayoutOf(args.cameras, gl_WorkGroupID.y);
  const uint row_pairs = camera.row_words / 2;
  const uint y = gl_GlobalInvocationID.x / row_pairs, pair = gl_GlobalInvocationID.x % row_pairs;
  if (y >= camera.height) return;
  const uint own = camera.mask_words / 2 + gl_GlobalInvocationID.x;
  const uint64_t one = args.levels.at[kScoreLevels * own];
  if (one == 0ul || !isNearObject(camera, y, pair)) {  // most of an image: empty, or background noise
    args.masks.at[own] = one;
    return;
  }

  // which pixels have a neighbour of each kind within reach, by direction: 0 1 2 above, 3 and 5 left and right, 6 7 8 below; 8 - d is
  // opposite d
  uint64_t near[3][9];
  for (uint kind = 0; kind < 3; ++kind)
    for (uint d = 0; d < 9; ++d) near[kind][d] = 0ul;
  for (int dy = -kSmearReach; dy <= kSmearReach; ++dy) {
    const uint row = y + uint(dy);
    if (row >= camera.height) continue;
    const uint row_start = camera.mask_words / 2 + row * row_pairs;
    const int first = dy == 0 ? 1 : abs(dy), last = dy == 0 ? kSmearReach : abs(dy);
    const int d = 4 + 3 * sign(dy);
    for (uint kind = 0; kind < 3; ++kind) {
      const uint64_t here = pixelsOf(camera, kind, row_start, pair);
      const uint64_t before = pixelsOf(camera, kind, row_start, pair - 1), behind = pixelsOf(camera, kind, row_start, pair + 1);
      if (dy != 0) near[kind][d] |= here;
      for (int dx = first; dx <= last; ++dx) {
        near[kind][d - 1] |= here << dx | before >> (64 - dx);
        near[kind][d + 1] |= here >> dx | behind << (64 - dx);
      }
    }
  }
  // a score in [1, 2) next to 4 or more, or in [2, 4) next to 8 or more, is less than half
  const uint64_t two = args.levels.at[kScoreLevels * own + 1], four = args.levels.at[kScoreLevels * own + 2];
  uint64_t smear = 0ul;
  for (uint d = 0; d < 9; ++d) smear |= near[kBackground][8 - d] & ((~two & near[kFour][d]) | (~four & near[kEight][d]));
  args.masks.at[own] = one & ~smear;
}
