#version 460
// SPDX-License-Identifier: MIT
// The gain of each channel of a camera against its background: exposure and white balance drift. One workgroup per camera.
#extension GL_GOOGLE_include_directive : require
#include "shaders/camera/image_layout.glsl"
#include "shaders/silhouette/evidence_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { EvidenceGainArgs args; };

shared uint bins[3 * kGainBins];

float ratioOf(uint bin) { return kLeastGain + (float(bin) + 0.5) / float(kGainBins); }

float gainOf(uint channel) {
  const uint first = channel * kGainBins;
  uint total = 0;
  for (uint i = 0; i < kGainBins; ++i) total += bins[first + i];
  if (total == 0) return 1;
  uint median = 0;
  for (uint below = 0; median < kGainBins - 1; ++median) {
    below += bins[first + median];
    if (2 * below >= total) break;
  }
  float gain = ratioOf(median);
  for (uint round_ = 0; round_ < kGainRounds; ++round_) {
    float sum = 0, weight = 0;
    for (uint i = 0; i < kGainBins; ++i) {
      if (abs(ratioOf(i) - gain) >= kGainSpread * gain) continue;
      sum += float(bins[first + i]) * ratioOf(i);
      weight += float(bins[first + i]);
    }
    if (weight > 0) gain = sum / weight;
  }
  return gain;
}

void main() {
  const ImageLayout camera = imageLayoutOf(args.cameras, gl_WorkGroupID.x);
  for (uint i = gl_LocalInvocationID.x; i < 3 * kGainBins; i += gl_WorkGroupSize.x) bins[i] = 0;
  barrier();
  const uint columns = camera.width / kGainStep, rows = camera.height / kGainStep;
  for (uint i = gl_LocalInvocationID.x; i < columns * rows; i += gl_WorkGroupSize.x) {
    const uint pixel = (i / columns * kGainStep + kGainStep / 2) * camera.width + i % columns * kGainStep + kGainStep / 2;
    const uint word = camera.image_words + 3 * pixel / 4, shift = 8 * (3 * pixel & 3u);
    const uint seen = uint(packUint2x32(uvec2(args.images.at[word], args.images.at[word + 1])) >> shift);
    const uint model = args.model.at[camera.pixels_before + pixel];
    for (uint channel = 0; channel < 3; ++channel) {
      const uint value = seen >> (8 * channel) & 255u, mean = model >> (8 * channel) & 255u;
      if (value > kGainSaturated || mean > kGainSaturated || mean < kGainDark) continue;
      const float ratio = (float(value) + kGainOffset) / (float(mean) + kGainOffset);
      const int bin = int(floor((ratio - kLeastGain) * float(kGainBins)));
      if (bin >= 0 && bin < int(kGainBins)) atomicAdd(bins[channel * kGainBins + bin], 1);
    }
  }
  barrier();
  if (gl_LocalInvocationID.x < 3) args.gains.at[4 * gl_WorkGroupID.x + gl_LocalInvocationID.x] = gainOf(gl_LocalInvocationID.x);
}
