#version 460
// SPDX-License-Identifier: MIT
// Adds a frame of the empty workspace to the background's sums: one invocation per pixel.
#extension GL_GOOGLE_include_directive : require
#include "shaders/camera/image_layout.glsl"
#include "shaders/silhouette/silhouette_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { BackgroundArgs args; };

void main() {
  const ImageLayout camera = imageLayoutOf(args.cameras, args.first_camera + gl_WorkGroupID.y);
  const uint pixel = gl_GlobalInvocationID.x;
  if (pixel >= camera.width * camera.height) return;
  // its three bytes are in one word or in two
  const uint word = camera.image_words + 3 * pixel / 4, shift = 8 * (3 * pixel & 3u);
  const uint bytes = uint(packUint2x32(uvec2(args.images.at[word], args.images.at[word + 1])) >> shift);
  for (uint channel = 0; channel < 3; ++channel) {
    const uint value = bytes >> (8 * channel) & 255u;
    args.sums.at[kLearnSums * (camera.pixels_before + pixel) + channel] += packUint2x32(uvec2(value, value * value));
  }
}
