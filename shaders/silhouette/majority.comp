#version 460
// SPDX-License-Identifier: MIT
// Removes speckle and smooths edges by the 3 x 3 majority, 64 pixels at once: carry-save adders sum the nine bits of a neighbourhood.
// Outside the image counts as background.
#extension GL_GOOGLE_include_directive : require
#include "shaders/camera/image_layout.glsl"
#include "shaders/silhouette/silhouette_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { MajorityArgs args; };

struct Sum {  // of three bits, 64 times
  uint64_t ones, twos;
};

Sum add(uint64_t a, uint64_t b, uint64_t c) { return Sum(a ^ b ^ c, (a & b) | (c & (a ^ b))); }

void main() {
  const ImageLayout camera = imageLayoutOf(args.cameras, gl_WorkGroupID.y);
  const uint row_pairs = camera.row_words / 2;
  const uint y = gl_GlobalInvocationID.x / row_pairs, pair = gl_GlobalInvocationID.x % row_pairs;
  if (y >= camera.height) return;
  const uint own = camera.mask_words / 2 + gl_GlobalInvocationID.x;

  uint64_t here[3];
  for (uint k = 0; k < 3; ++k) {
    const uint row = y + k - 1;  // wraps below 0: not less than the height
    here[k] = row < camera.height ? args.masks.at[own + (k - 1) * row_pairs] : 0ul;
  }
  // if all three are empty, a neighbouring column contributes three pixels at most
  if ((here[0] | here[1] | here[2]) == 0ul) {
    args.cleaned.at[own] = 0ul;
    return;
  }
  Sum rows[3];
  for (uint k = 0; k < 3; ++k) {
    const bool inside = y + k - 1 < camera.height;
    const uint at = own + (k - 1) * row_pairs;
    const uint64_t before = inside && pair > 0 ? args.masks.at[at - 1] : 0ul;
    const uint64_t behind = inside && pair + 1 < row_pairs ? args.masks.at[at + 1] : 0ul;
    rows[k] = add(here[k] << 1 | before >> 63, here[k], here[k] >> 1 | behind << 63);
  }
  const Sum ones = add(rows[0].ones, rows[1].ones, rows[2].ones);
  const Sum twos = add(rows[0].twos, rows[1].twos, rows[2].twos);
  // sum = ones.ones + 2 (ones.twos + twos.ones) + 4 twos.twos; at least 5
  const uint64_t two = ones.twos ^ twos.ones, carry = ones.twos & twos.ones;
  const uint64_t four = carry ^ twos.twos, eight = carry & twos.twos;
  // a set pixel past the right edge would not belong to the image
  const uint pixels = camera.width - 64 * pair;
  args.cleaned.at[own] = (eight | (four & (two | ones.ones))) & (pixels < 64 ? (1ul << pixels) - 1ul : ~0ul);
}
