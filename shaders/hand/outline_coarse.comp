#version 460
// SPDX-License-Identifier: MIT
// Searches an edge along its line in the evidence for the hand: the mean and variance of its place.
#extension GL_GOOGLE_include_directive : require
layout(constant_id = 3) const uint kLenses = 15;
#include "shaders/hand/outline_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { OutlineCoarseArgs args; };

#include "shaders/hand/outline_line.glsl"
#include "shaders/silhouette/evidence.glsl"

float evidenceAt(TileLayout tiles, GpuTileRegion region, vec2 point) {
  const uvec2 pixel = uvec2(floor(point + 0.5)), tile = pixel / kEvidenceTile;
  if (tile.x < region.low[0] || tile.y < region.low[1] || tile.x >= region.high[0] || tile.y >= region.high[1]) return 0;
  const uint cell = cellIndex(tiles, pixel.x / kCellPixels, pixel.y / kCellPixels);
  const uint value = args.evidence.at[cell / 4] >> (8 * (cell & 3u)) & 255u;
  return (float(value >> 1) - float(kEvidenceZero)) / kEvidenceSteps;
}

void main() {
  const uint index = gl_WorkGroupID.y, entry = gl_GlobalInvocationID.x;
  if (entry >= args.lists.at[index * kOutlineList]) return;
  const uint result = index * kOutlineLines + entry;
  const ImageLayout image = imageLayoutOf(args.cameras, index);
  const Line line = lineOf(image, index, entry, args.reach);
  if (line.length_ == 0) {
    args.lines.at[result] = kNoLine;
    return;
  }
  const TileLayout tiles = tileLayoutOf(image);
  const GpuTileRegion region = args.regions.at[index];
  // the distribution's moments, scaled by exp(-highest)
  const float prior = 0.5 / (args.spread * args.spread);
  float d = -float(line.inside) - 0.5, sum = 0, highest = -prior * d * d;
  float mass = 1, mean = d, square = d * d;
  for (int k = -int(line.inside); k <= int(line.outside); ++k) {
    sum += kEvidenceTrust * evidenceAt(tiles, region, line.point + float(k) * line.normal);
    d = float(k) + 0.5;
    const float exponent = sum - prior * d * d;
    const float top = max(highest, exponent), old = exp(highest - top), weight = exp(exponent - top);
    mass = mass * old + weight;
    mean = mean * old + weight * d;
    square = square * old + weight * d * d;
    highest = top;
  }
  mean /= mass;
  const float variance = square / mass - mean * mean + 1.0 / 12;
  // without the prior
  const float information = 1 / variance - 2 * prior;
  GpuOutlineLine found = kNoLine;
  found.length_ = line.length_;
  found.judged = 1;
  if (information > 0) {
    found.offset = mean / variance / information;
    if (abs(found.offset) <= 2 * float(args.reach)) {
      const float outlier = found.offset / (1.5 * args.spread);
      found.weight = min(information, 1 / (kCoarseDeviation * kCoarseDeviation)) / (1 + outlier * outlier) *
                     min(line.length_, kLongestLine) / kLinePixels;
      found.row = rowOf(args.cameras.at[index], line, poseAt(args.pose, args.frame, index));
      found.blur = blurOf(found.row);
    }
  }
  args.lines.at[result] = found;
}
