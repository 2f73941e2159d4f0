#version 460
// SPDX-License-Identifier: MIT
// A damped Gauss-Newton step of pose and scale from the lines of all cameras. One workgroup.
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "shaders/hand/outline_io.h"
#include "shaders/core/quaternion.glsl"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { OutlineSolveArgs args; };

const uint kGradient = kOutlineSums;  // 7
const uint kResidual = 35, kWeight = 36, kLines = 37, kLength = 38, kGood = 39, kJudged = 40, kTotals = 41;

shared float shared_sums[kTotals * 32];  // at most 32 subgroups

// Sums over the workgroup, in a fixed order.
void reduce(inout float sums[kTotals]) {
  for (uint k = 0; k < kTotals; ++k) sums[k] = subgroupAdd(sums[k]);
  if (gl_NumSubgroups == 1) return;
  barrier();  // the sums of the last camera have been read
  if (subgroupElect())
    for (uint k = 0; k < kTotals; ++k) shared_sums[k * 32 + gl_SubgroupID] = sums[k];
  barrier();
  for (uint k = 0; k < kTotals; ++k) {
    float sum = 0;
    for (uint group = 0; group < gl_NumSubgroups; ++group) sum += shared_sums[k * 32 + group];
    sums[k] = sum;
  }
}

void main() {
  float totals[kTotals];
  for (uint k = 0; k < kTotals; ++k) totals[k] = 0;
  for (uint camera = 0; camera < args.cameras; ++camera) {
    float sums[kTotals];
    for (uint k = 0; k < kTotals; ++k) sums[k] = 0;
    const uint count = args.lists.at[camera * kOutlineList];
    for (uint i = gl_LocalInvocationID.x; i < count; i += gl_WorkGroupSize.x) {
      const GpuOutlineLine line = args.lines.at[camera * kOutlineLines + i];
      sums[kLength] += line.length_;
      if (line.judged != 0) sums[kJudged] += line.length_;
      if (line.weight <= 0) continue;
      uint k = 0;
      for (uint row = 0; row < kOutlineUnknowns; ++row) {
        const float weighted = line.weight * line.row[row];
        for (uint column = 0; column <= row; ++column) sums[k++] += weighted * line.row[column];
        sums[kGradient + row] += weighted * line.offset;
      }
      sums[kResidual] += line.weight * line.offset * line.offset;
      sums[kWeight] += line.weight;
      sums[kLines] += 1;
      if (abs(line.offset) < kGoodOffset + 0.5 * line.blur) sums[kGood] += line.length_;
    }
    reduce(sums);
    if (gl_LocalInvocationID.x == 0) {
      args.result.at[0].camera_length[camera] = sums[kLength];
      args.result.at[0].camera_good[camera] = sums[kGood];
    }
    for (uint k = 0; k < kTotals; ++k) totals[k] += sums[k];
  }
  if (gl_LocalInvocationID.x != 0) return;

  GpuOutlinePose pose = args.pose.at[0];
  for (uint k = 0; k < kOutlineSums; ++k) args.result.at[0].information[k] = totals[k];
  args.result.at[0].residual = totals[kResidual];
  args.result.at[0].weight = totals[kWeight];
  args.result.at[0].lines = uint(totals[kLines]);
  args.result.at[0].judged_length = totals[kJudged];

  // Cholesky's factorization of the damped matrix; a fixed scale has no row
  const uint unknowns = args.scale_weight > 0 ? kOutlineUnknowns : kOutlineUnknowns - 1;
  float a[kOutlineSums], delta[kOutlineUnknowns];
  for (uint k = 0; k < kOutlineSums; ++k) a[k] = totals[k];
  float right[kOutlineUnknowns];
  for (uint k = 0; k < kOutlineUnknowns; ++k) right[k] = totals[kGradient + k];
  for (uint k = 0; k < 6; ++k) a[k * (k + 3) / 2] += k < 3 ? 1 / (kOutlineShift * kOutlineShift) : 1 / (kOutlineTurn * kOutlineTurn);
  a[27] += args.scale_weight;
  right[6] += args.scale_weight * (args.prior_scale - log(pose.scale));
  for (uint row = 0; row < unknowns; ++row)
    for (uint column = 0; column <= row; ++column) {
      const uint at = row * (row + 1) / 2, other = column * (column + 1) / 2;
      float sum = a[at + column];
      for (uint k = 0; k < column; ++k) sum -= a[at + k] * a[other + k];
      a[at + column] = row == column ? sqrt(max(sum, 1e-12)) : sum / a[other + column];
    }
  for (uint row = 0; row < unknowns; ++row) {
    float sum = right[row];
    for (uint k = 0; k < row; ++k) sum -= a[row * (row + 1) / 2 + k] * delta[k];
    delta[row] = sum / a[row * (row + 1) / 2 + row];
  }
  for (int row = int(unknowns) - 1; row >= 0; --row) {
    float sum = delta[row];
    for (uint k = uint(row) + 1; k < unknowns; ++k) sum -= a[k * (k + 1) / 2 + uint(row)] * delta[k];
    delta[row] = sum / a[uint(row) * (uint(row) + 1) / 2 + uint(row)];
  }
  vec3 shift = vec3(delta[0], delta[1], delta[2]), turn = vec3(delta[3], delta[4], delta[5]);
  const float step_ = min(1, min(kOutlineMaxShift / max(length(shift), 1e-9), kOutlineMaxTurn / max(length(turn), 1e-9)));
  const float angle = step_ * length(turn);
  const vec3 axis = angle > 1e-9 ? normalize(turn) : vec3(1, 0, 0);
  pose.position += step_ * shift;
  pose.rotation = normalize(multiply(vec4(axis * sin(0.5 * angle), cos(0.5 * angle)), pose.rotation));
  if (args.scale_weight > 0) pose.scale *= exp(clamp(step_ * delta[6], -0.05, 0.05));
  args.pose.at[0] = pose;
  args.result.at[0].pose = pose;
}
