#version 460
// SPDX-License-Identifier: MIT
// Pushes the skeletal model into the voxel model by forces on its patches: section 2 of the paper, eq. (1) m x'' = F and (2) I θ'' = N.
//
// A patch at signed distance s outside feels the force f = -a φ(s) n along its own normal n, inwards, with φ(s) = max(0, s + margin). The
// force grows with how far the patch sticks out, and starts a little inside, so that patches on opposite sides balance. N is taken about
// the centre of gravity.
// A step of time h of (1) and (2) is implicit in the contact stiffness K = Σ a φ'(s) J Jᵀ, J = (n, r x n):
//     (M / h² + K) Δ = (F, N),   M = diag(m, I),
// which pushes a free body for small h and is a Newton step for large h. One workgroup per hypothesis.
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "shaders/hand/fit_io.h"
#include "shaders/core/quaternion.glsl"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { FitArgs args; };

const uint kForce = 0, kMoment = 3, kStiffness = 6;     // 21: lower triangle, row by row
const uint kOutside = 27, kCount = 28, kSums = 29;
// M / h² as a fraction of K with every patch in contact: enough to carry the directions that no patch resists.
const float kInertiaShare = 0.01;
// The limits of one step: the distance field is approximately linear this far.
const float kMaxTurn = 0.25;   // rad
const float kMaxShift = 0.03;  // m
// 20 µm, and the turn that moves a fingertip by as much: steps shrink by half, so the same is left, a hundredth of a voxel.
const float kStallShift = 2e-5, kStallTurn = 2e-4;

shared float shared_sums[kSums * 32];  // at most 32 subgroups

READ_POINTER(ReadPatchWords, uint64_t)

// Loads a patch with four loads of two words, in GpuPatch's order.
GpuPatch loadPatch(uint index) {
  ReadPatchWords words = ReadPatchWords(uint64_t(args.patches) + 32ul * index);
  const uvec2 a = unpackUint2x32(words.at[0]), b = unpackUint2x32(words.at[1]), c = unpackUint2x32(words.at[2]),
              d = unpackUint2x32(words.at[3]);
  GpuPatch patch_;
  patch_.center = uintBitsToFloat(uvec3(a, b.x));
  patch_.area = uintBitsToFloat(b.y);
  patch_.normal = uintBitsToFloat(uvec3(c, d.x));
  patch_.cut = d.y;
  return patch_;
}

// Trilinear interpolation of the signed distance; outside the box of cells, the border's value. An entry has two cells, one above the
// other.
float distanceAt(vec3 point) {
  const vec3 last = vec3(args.field_size[0], args.field_size[1], args.field_size[2]) - 1.001;
  const vec3 at = clamp((point - args.field_low) / args.cell_m, vec3(0), last);
  const uvec3 cell = uvec3(at);
  const vec3 t = at - vec3(cell);
  const uint dy = args.field_size[0];
  const uint i = cell.x + dy * (cell.y + args.field_size[1] * cell.z);
  const vec2 z00 = uintBitsToFloat(unpackUint2x32(args.distances.at[i]));
  const vec2 z10 = uintBitsToFloat(unpackUint2x32(args.distances.at[i + 1]));
  const vec2 z01 = uintBitsToFloat(unpackUint2x32(args.distances.at[i + dy]));
  const vec2 z11 = uintBitsToFloat(unpackUint2x32(args.distances.at[i + dy + 1]));
  const vec2 z = mix(mix(z00, z10, t.x), mix(z01, z11, t.x), t.y);
  return mix(z.x, z.y, t.z);
}

void addPatch(GpuPatch patch_, vec4 rotation, vec3 position, inout float sums[kSums]) {
  const vec3 r = rotate(rotation, patch_.center);
  const vec3 n = rotate(rotation, patch_.normal);
  // where the forearm continues, the surface is assumed to end at the patch: its constant push balances the fingertips'
  const float s = patch_.cut != 0 ? 0 : distanceAt(position + r);
  const float push = s + args.margin_m;
  if (patch_.cut == 0 && s > 0) {
    sums[kOutside] += patch_.area * s;
    sums[kCount] += 1;
  }
  if (push <= 0) return;
  const vec3 m = cross(r, n);
  const float weight = patch_.area;
  const float force = -weight * push;
  const float j[6] = {n.x, n.y, n.z, m.x, m.y, m.z};
  uint k = kStiffness;
  const float stiff = patch_.cut != 0 ? 0 : weight;
  for (uint row = 0; row < 6; ++row) {
    sums[kForce + row] += force * j[row];
    for (uint column = 0; column <= row; ++column) sums[k++] += stiff * j[row] * j[column];
  }
}

// Sums over the workgroup, in a fixed order.
void reduce(inout float sums[kSums]) {
  for (uint k = 0; k < kSums; ++k) sums[k] = subgroupAdd(sums[k]);
  if (gl_NumSubgroups == 1) return;
  barrier();  // the sums of the last iteration have been read
  if (subgroupElect())
    for (uint k = 0; k < kSums; ++k) shared_sums[k * 32 + gl_SubgroupID] = sums[k];
  barrier();
  for (uint k = 0; k < kSums; ++k) {
    float sum = 0;
    for (uint group = 0; group < gl_NumSubgroups; ++group) sum += shared_sums[k * 32 + group];
    sums[k] = sum;
  }
}

// (M / h² + K) Δ = (F, N) by Cholesky's factorization.
void solveStep(float sums[kSums], vec4 rotation, out float delta[6]) {
  float a[21];
  for (uint k = 0; k < 21; ++k) a[k] = sums[kStiffness + k];
  // the inertia rotated into the workspace axes
  const mat3 turn = mat3(rotate(rotation, vec3(1, 0, 0)), rotate(rotation, vec3(0, 1, 0)), rotate(rotation, vec3(0, 0, 1)));
  const vec3 low = args.inertia_low, high = args.inertia_high;
  const mat3 inertia = turn * mat3(low.x, high.x, high.y, high.x, low.y, high.z, high.y, high.z, low.z) * transpose(turn);
  const float mass = kInertiaShare * args.patch_area;
  for (uint row = 0, k = 0; row < 6; ++row)
    for (uint column = 0; column <= row; ++column, ++k) {
      if (row < 3) a[k] += row == column ? mass : 0;
      else if (column >= 3) a[k] += mass * inertia[column - 3][row - 3];
    }

  for (uint row = 0; row < 6; ++row)
    for (uint column = 0; column <= row; ++column) {
      const uint at = row * (row + 1) / 2, other = column * (column + 1) / 2;
      float sum = a[at + column];
      for (uint k = 0; k < column; ++k) sum -= a[at + k] * a[other + k];
      a[at + column] = row == column ? sqrt(sum) : sum / a[other + column];
    }
  for (uint row = 0; row < 6; ++row) {
    float sum = sums[kForce + row];
    for (uint k = 0; k < row; ++k) sum -= a[row * (row + 1) / 2 + k] * delta[k];
    delta[row] = sum / a[row * (row + 1) / 2 + row];
  }
  for (int row = 5; row >= 0; --row) {
    float sum = delta[row];
    for (uint k = uint(row) + 1; k < 6; ++k) sum -= a[k * (k + 1) / 2 + uint(row)] * delta[k];
    delta[row] = sum / a[uint(row) * (uint(row) + 1) / 2 + uint(row)];
  }
}

void main() {
  const uint hypothesis = gl_WorkGroupID.x;
  vec4 rotation = args.fits.at[hypothesis].pose.rotation;
  vec3 position = args.fits.at[hypothesis].pose.position;
  float sums[kSums];
  uint outcome = kFitOutOfIterations, iteration = 0;
  for (;; ++iteration) {
    for (uint k = 0; k < kSums; ++k) sums[k] = 0;
    for (uint i = gl_LocalInvocationID.x; i < args.patch_count; i += gl_WorkGroupSize.x)
      addPatch(loadPatch(i), rotation, position, sums);
    reduce(sums);
    if (sums[kCount] == 0) {
      outcome = kFitIncluded;
      break;
    }
    if (iteration == args.max_iterations) break;
    float delta[6];
    solveStep(sums, rotation, delta);
    vec3 shift = vec3(delta[0], delta[1], delta[2]), turn = vec3(delta[3], delta[4], delta[5]);
    const float scale = min(1, min(kMaxShift / max(length(shift), 1e-9), kMaxTurn / max(length(turn), 1e-9)));
    shift *= scale;
    turn *= scale;
    const float angle = length(turn);
    if (angle < kStallTurn && length(shift) < kStallShift) {
      outcome = kFitStalled;
      break;
    }
    position += shift;
    const vec3 axis = angle > 1e-9 ? turn / angle : vec3(1, 0, 0);
    rotation = normalize(multiply(vec4(axis * sin(0.5 * angle), cos(0.5 * angle)), rotation));
  }
  if (gl_LocalInvocationID.x != 0) return;
  args.fits.at[hypothesis].pose.rotation = rotation;
  args.fits.at[hypothesis].pose.position = position;
  args.fits.at[hypothesis].outside_m = sums[kOutside] / args.patch_area;
  args.fits.at[hypothesis].outside_fraction = sums[kCount] / float(args.patch_count);
  args.fits.at[hypothesis].outside_count = uint(sums[kCount] + 0.5);
  args.fits.at[hypothesis].iterations = iteration;
  args.fits.at[hypothesis].outcome = outcome;
}
