#version 460
// SPDX-License-Identifier: MIT
// A mask as an image, white on black.
#extension GL_GOOGLE_include_directive : require
#include "shaders/camera/image_layout.glsl"
#include "shaders/silhouette/evidence_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { MaskImageArgs args; };

void main() {
  const ImageLayout image = imageLayoutOf(args.cameras, gl_WorkGroupID.y);
  const uint bytes = 3 * image.width * image.height, first = 4 * gl_GlobalInvocationID.x;
  if (first >= bytes) return;
  uint word = 0;
  for (uint k = 0; k < 4 && first + k < bytes; ++k) {
    const uint pixel = (first + k) / 3, x = pixel % image.width, y = pixel / image.width;
    const uint bit = args.masks.at[image.mask_words + y * image.row_words + x / 32] >> (x & 31u) & 1u;
    word |= (bit * 255u) << (8 * k);
  }
  args.images.at[image.image_words + gl_GlobalInvocationID.x] = word;
}
