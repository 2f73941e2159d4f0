#version 460
// SPDX-License-Identifier: MIT
// Adds a frame of the empty workspace to the background's sums: one invocation a pixel.
#extension GL_GOOGLE_include_directive : require
#include "shaders/picture.glsl"
#include "shaders/silhouette_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { BackgroundArgs args; };

void main() {
  const Picture camera = pictureOf(args.cameras, gl_WorkGroupID.y);
  const uint pixel = gl_GlobalInvocationID.x;
  if (pixel >= camera.width * camera.height) return;
  const uint at = kLearnSums * (camera.pixels_before + pixel);
  for (uint channel = 0; channel < 3; ++channel) {
    const uint byte = 3 * pixel + channel;
    const uint value = args.pictures.at[camera.picture_words + byte / 4] >> (8 * (byte & 3u)) & 255u;
    args.sums.at[at + channel] += value;
    args.sums.at[at + 3 + channel] += value * value;
  }
}
