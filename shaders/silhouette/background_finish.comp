#version 460
// SPDX-License-Identifier: MIT
// Mean and spread of every pixel of the empty workspace, from the sums over its frames: one invocation per pixel.
#extension GL_GOOGLE_include_directive : require
#include "shaders/camera/image_layout.glsl"
#include "shaders/silhouette/silhouette_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { BackgroundArgs args; };

void main() {
  const ImageLayout camera = imageLayoutOf(args.cameras, args.first_camera + gl_WorkGroupID.y);
  const uint pixel = gl_GlobalInvocationID.x;
  if (pixel >= camera.width * camera.height) return;
  const uint at = kLearnSums * (camera.pixels_before + pixel);
  uint word = 0;
  float variance = 0;
  for (uint channel = 0; channel < 3; ++channel) {
    const uvec2 sums = unpackUint2x32(args.sums.at[at + channel]);
    const uint sum = sums.x, squares = sums.y;
    word |= (2 * sum + args.frames) / (2 * args.frames) << (8 * channel);  // rounded
    // n Σx² - (Σx)² in 64 bits: exact
    const uint64_t spread = uint64_t(args.frames) * squares - uint64_t(sum) * sum;
    if (args.frames > 1) variance += float(spread) / (float(args.frames) * float(args.frames - 1));
  }
  const float spread = max(sqrt(variance / 3), kMinSpread);
  args.model.at[camera.pixels_before + pixel] = word | uint(min(spread / kSpreadStep + 0.5, 255.0)) << 24;
}
