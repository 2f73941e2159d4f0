#version 460
// SPDX-License-Identifier: MIT
// Locates an edge along its line to a fraction of a pixel: colours inside, the known background outside.
#extension GL_GOOGLE_include_directive : require
layout(constant_id = 3) const uint kLenses = 15;
#include "shaders/hand/outline_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { OutlineFineArgs args; };

#include "shaders/hand/outline_line.glsl"

const int kSamples = kFineInside + kFineOutside + 1;

struct Sample {
  vec3 seen, background;
};

vec3 channels(uint word) { return vec3(word & 255u, word >> 8 & 255u, word >> 16 & 255u); }

READ_POINTER(ReadPair, uint64_t)

// Bilinear interpolation of an image, at the background's exposure, and of the background. Loads two words at a time.
Sample sampleAt(ImageLayout image, vec3 per_gain, vec2 point) {
  const vec2 low = floor(point), t = point - low;
  Sample sum = Sample(vec3(0), vec3(0));
  for (uint dy = 0; dy < 2; ++dy) {
    const uint pixel = (uint(low.y) + dy) * image.width + uint(low.x);
    // two pixels are six bytes of three words
    const uint word = image.image_words + 3 * pixel / 4, shift = 8 * (3 * pixel & 3u);
    const uvec2 first = unpackUint2x32(ReadPair(uint64_t(args.images) + 4ul * word).at[0]);
    const uint a = uint(packUint2x32(first) >> shift), b = uint(packUint2x32(uvec2(first.y, args.images.at[word + 2])) >> shift);
    const uvec2 mean = unpackUint2x32(ReadPair(uint64_t(args.model) + 4ul * (image.pixels_before + pixel)).at[0]);
    const float weight = dy == 1 ? t.y : 1 - t.y;
    sum.seen += weight * mix(channels(a), channels(a >> 24 | b << 8), t.x);
    sum.background += weight * mix(channels(mean.x), channels(mean.y), t.x);
  }
  sum.seen *= per_gain;
  return sum;
}

void main() {
  const uint index = gl_WorkGroupID.y, entry = gl_GlobalInvocationID.x;
  if (entry >= args.lists.at[index * kOutlineList]) return;
  const uint result = index * kOutlineLines + entry;
  const ImageLayout image = imageLayoutOf(args.cameras, index);
  const Line line = lineOf(image, index, entry, uint(kFineFar));
  const int inside = min(int(line.inside), kFineInside), outside = min(int(line.outside), kFineOutside);
  const int far = min(int(line.outside), kFineFar);
  GpuOutlineLine found = kNoLine;
  found.length_ = line.length_;
  if (line.length_ == 0 || inside < kFineShortest || far < kFineNear) {
    args.lines.at[result] = found;
    return;
  }
  found.judged = 1;
  found.row = rowOf(args.cameras.at[index], line, poseAt(args.pose, args.frame, index));
  found.blur = blurOf(found.row);
  const float ramp = kFineRamp;
  const vec3 per_gain = 1 / vec3(args.gains.at[4 * index], args.gains.at[4 * index + 1], args.gains.at[4 * index + 2]);
  vec3 seen[kSamples], background[kSamples];
  vec3 far_seen = vec3(0), far_background = vec3(0);
  float far_count = 0;
  for (int k = -kFineInside; k <= kFineFar; ++k) {
    if (k < -inside || k > max(outside, far)) continue;
    const Sample at = sampleAt(image, per_gain, line.point + float(k) * line.normal);
    if (k <= kFineOutside) {
      seen[k + kFineInside] = at.seen;
      background[k + kFineInside] = at.background;
    }
    if (k >= kFineNear && k <= far) {
      far_seen += at.seen;
      far_background += at.background;
      far_count += 1;
    }
  }
  const float light = clamp(dot(far_seen, far_background) / max(dot(far_background, far_background), 1), kFullShadow, kMostLight);
  const bool somebody = length(far_seen - light * far_background) > kFineOther * far_count;
  for (int k = -inside; k <= outside; ++k)
    background[k + kFineInside] = somebody ? far_seen / far_count : light * background[k + kFineInside];

  // For an edge at e, pixel x shows S F + (1 - S) B with S = ½ - (x - e) / ramp clamped, and F = f₀ + f₁ (x - e) by linear least squares.
  const float low = max(-float(kFineReach), 1.5 - float(inside)), high = min(float(kFineReach), float(outside) - 0.5);
  const int count = int(floor((high - low) / kFineStep + 1e-4)) + 1;
  const int kCandidates = 2 * kFineReach * 2 + 1;
  float costs[kCandidates];
  float least = 1e30;
  int best = 0;
  for (int i = 0; i < count; ++i) {
    const float e = low + kFineStep * float(i);
    const float prior = (kFineNoise / kFineSlope) * (kFineNoise / kFineSlope);
    float a00 = 1e-6, a01 = 0, a11 = prior, square = 0;
    vec3 r0 = vec3(0), r1 = vec3(0);
    for (int k = -inside; k <= outside; ++k) {
      const float x = float(k) - e, s = clamp(0.5 - x / ramp, 0, 1);
      const vec3 y = seen[k + kFineInside] - (1 - s) * background[k + kFineInside];
      a00 += s * s;
      a01 += s * s * x;
      a11 += s * s * x * x;
      r0 += s * y;
      r1 += s * x * y;
      square += dot(y, y);
    }
    const float determinant = a00 * a11 - a01 * a01;
    const vec3 f0 = (a11 * r0 - a01 * r1) / determinant, f1 = (a00 * r1 - a01 * r0) / determinant;
    costs[i] = (square - dot(f0, r0) - dot(f1, r1)) / (2 * kFineNoise * kFineNoise);
    if (costs[i] < least) {
      least = costs[i];
      best = i;
    }
  }
  if (count >= 3) {
    float mass = 0, mean = 0, variance = 0;
    for (int i = 0; i < count; ++i) {
      const float weight = exp(least - costs[i]), e = low + kFineStep * float(i);
      mass += weight;
      mean += weight * e;
      variance += weight * e * e;
    }
    mean /= mass;
    variance = variance / mass - mean * mean;
    if (variance < 0.1 && best > 0 && best < count - 1) {
      // between candidates: the parabola's minimum
      const float curvature = max(costs[best - 1] - 2 * costs[best] + costs[best + 1], 1e-9);
      mean = low + kFineStep * (float(best) + 0.5 * (costs[best - 1] - costs[best + 1]) / curvature);
      variance = max(variance, kFineStep * kFineStep / curvature);
    }
    if (variance < kFineFlat * (high - low) * (high - low) / 12) {
      found.offset = mean;
      const float outlier = mean / (kFineOutlier);
      found.weight = 1 / (variance + kFineDeviation * kFineDeviation) / (1 + outlier * outlier) * min(line.length_, kLongestLine) / kLinePixels;
    }
  }
  args.lines.at[result] = found;
}
