#version 460
// SPDX-License-Identifier: MIT
// Removes speckle and smooths edges by the 3 x 3 majority, 32 pixels at once: the nine bits of a neighbourhood are added by carry-save
// adders. Outside the picture counts as background.
#extension GL_GOOGLE_include_directive : require
#include "shaders/picture.glsl"
#include "shaders/silhouette_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { MajorityArgs args; };

struct Sum {  // of three bits, 32 times
  uint ones, twos;
};

Sum add(uint a, uint b, uint c) { return Sum(a ^ b ^ c, (a & b) | (c & (a ^ b))); }

void main() {
  const Picture camera = pictureOf(args.cameras, gl_WorkGroupID.y);
  const uint y = gl_GlobalInvocationID.x / camera.row_words, w = gl_GlobalInvocationID.x % camera.row_words;
  if (y >= camera.height) return;

  Sum rows[3];
  for (uint k = 0; k < 3; ++k) {
    const uint row = y + k - 1;  // wraps below 0: not less than the height
    uint here = 0, before = 0, behind = 0;
    if (row < camera.height) {
      const uint at = camera.mask_words + row * camera.row_words + w;
      here = args.masks.at[at];
      before = w > 0 ? args.masks.at[at - 1] : 0;
      behind = w + 1 < camera.row_words ? args.masks.at[at + 1] : 0;
    }
    rows[k] = add(here << 1 | before >> 31, here, here >> 1 | behind << 31);
  }
  const Sum ones = add(rows[0].ones, rows[1].ones, rows[2].ones);
  const Sum twos = add(rows[0].twos, rows[1].twos, rows[2].twos);
  // sum = ones.ones + 2 (ones.twos + twos.ones) + 4 twos.twos; at least 5
  const uint two = ones.twos ^ twos.ones, carry = ones.twos & twos.ones;
  const uint four = carry ^ twos.twos, eight = carry & twos.twos;
  args.cleaned.at[camera.mask_words + y * camera.row_words + w] = eight | (four & (two | ones.ones));
}
