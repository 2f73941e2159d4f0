#version 460
// SPDX-License-Identifier: MIT
// Coarse to fine: one invocation classifies a run of blocks as empty, full or mixed, from every camera's verdict on their footprints.
#extension GL_GOOGLE_include_directive : require
#include "shaders/camera/camera_io.h"
layout(constant_id = 3) const uint kLenses = 15;
layout(constant_id = 4) const uint kLanes = 1;
#include "shaders/camera/lens.glsl"
#include "shaders/camera/load_camera.glsl"
#include "shaders/hull/footprint.glsl"
#include "shaders/hull/hull_sums.glsl"
#include "shaders/hull/occupancy.glsl"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint kSize = 8;  // voxels along a block's edge: 32, 8 or 4
layout(constant_id = 2) const uint kRun = 4;   // blocks per invocation, along x
layout(push_constant, scalar) uniform Push { CarveBlockArgs args; };

const uint kLongestRun = 4;

// A camera's verdict on a block's voxels.
const uint kNothing = 0;  // it sees none
const uint kOutside = 1;  // it sees all, none in the silhouette
const uint kInside = 2;   // all in the silhouette
const uint kUndecided = 3;

// The tile size that it reads.
const bool kLarge = kSize == kTopVoxels;
const uint kTile = kLarge ? kLargeTilePixels : kTilePixels;
const uint kTiles = kEntryPixels / kTile;

uint verdict(GpuCamera camera, Footprint footprint) {
  if (footprint.seen != kWholeSeen) return footprint.seen == kUnseen ? kNothing : kUndecided;
  // any and all over the rectangle's tiles
  const uvec2 first = pixelAt(footprint.low) / kTile, last = pixelAt(footprint.high) / kTile;
  uint any_set = 0, any_clear = 0;
  for (uint y = first.y; y <= last.y; ++y) {
    const uint row = kLarge ? kBandRows * y + kBandRows - 1 : y + y / (kBandRows - 1);
    for (uint entry = first.x / kTiles; entry <= last.x / kTiles; ++entry) {
      const uint from = max(first.x, entry * kTiles) % kTiles;
      const uint to = min(last.x, entry * kTiles + kTiles - 1) % kTiles;
      const uint columns = (~0u << from) & (~0u >> (31 - to));
      const uvec2 tiles = unpackUint2x32(args.tiles.at[camera.first_entry + row * camera.tile_entries + entry]);
      any_set |= tiles.x & columns;
      any_clear |= ~tiles.y & columns;
    }
  }
  return any_set == 0 ? kOutside : any_clear == 0 ? kInside : kUndecided;
}

void writeUniform(uvec3 block, bool full) {
  const uint bricks_edge = (args.voxels + kBrickVoxels - 1) / kBrickVoxels;
  const uint state = full ? kBrickFull : kBrickEmpty;
  if (kSize == kTopVoxels) {
    const uvec3 low = block * (kTopVoxels / kBrickVoxels);
    const uvec3 high = min(low + kTopVoxels / kBrickVoxels, uvec3(bricks_edge));
    for (uint z = low.z; z < high.z; ++z)
      for (uint y = low.y; y < high.y; ++y)
        for (uint x = low.x; x < high.x; ++x) args.brick_states.at[brickIndex(uvec3(x, y, z), bricks_edge)] = state;
  } else if (kSize == kBrickVoxels) {
    args.brick_states.at[brickIndex(block, bricks_edge)] = state;
  } else {
    const uint word = blockWord(block * kBlockVoxels, bricks_edge);
    args.words.at[word] = full ? ~0u : 0u;
    args.words.at[word + 1] = full ? ~0u : 0u;
  }
}

// Appends to the list that the next kernel processes. Its order varies from run to run; what is written for each block does not.
void append(uvec3 corner, uint undecided, uint seen) {
  if (kSize == kBrickVoxels) {
    const uint bricks_edge = (args.voxels + kBrickVoxels - 1) / kBrickVoxels;
    args.brick_states.at[brickIndex(corner, bricks_edge)] = kBrickMixed;
  }
  const uint slot = atomicAdd(args.mixed_count.at[0].count, 1);
  const uint invocations = (slot + 1) * args.next_invocations;
  atomicMax(args.mixed_count.at[0].groups_x, (invocations + gl_WorkGroupSize.x - 1) / gl_WorkGroupSize.x);
  args.mixed.at[slot] = MixedBlock(corner.x | corner.y << 10 | corner.z << 20, undecided, seen);
}

void main() {
  const uint runs = args.runs_edge * args.children_edge * args.children_edge;
  const uint parent_index = gl_GlobalInvocationID.x / runs;
  const uint run = gl_GlobalInvocationID.x % runs;
  const bool top = kSize == kTopVoxels;
  const bool idle = parent_index >= (top ? 1 : args.parent_count.at[0].count);  // idle invocations still help to load cameras

  MixedBlock block = MixedBlock(0, 0, 0);
  uvec3 parent_corner = uvec3(0);
  if (top && !idle) {
    block.cameras = args.camera_bits;
  } else if (!idle) {
    block = args.parents.at[parent_index];
    parent_corner = uvec3(block.low_corner, block.low_corner >> 10, block.low_corner >> 20) & 1023u;
  }
  const uvec3 corner = parent_corner * args.children_edge +
                       uvec3(run % args.runs_edge * kRun, run / args.runs_edge % args.children_edge,
                             run / (args.runs_edge * args.children_edge));
  const vec3 center = args.voxel_m * (vec3(corner * kSize) + 0.5 * float(kSize) - 0.5 * float(args.voxels));
  const float half_size = args.voxel_m * (0.5 * float(kSize - 1));

  uint undecided[kLongestRun], seen[kLongestRun];
  bool empty[kLongestRun];
  for (uint i = 0; i < kRun; ++i) {
    undecided[i] = 0;
    seen[i] = block.seen;
    empty[i] = idle;
  }
  for (uint cameras = subgroupOr(block.cameras); cameras != 0; cameras &= cameras - 1) {
    const uint index = findLSB(cameras);
    const GpuCamera camera = loadCamera(args.cameras, index);
    const vec3 origin = camera.rotation * center + camera.translation;
    const vec3 step = camera.rotation[0] * (args.voxel_m * float(kSize));
    for (uint i = 0; i < kRun; ++i) {
      if (empty[i] || (block.cameras >> index & 1u) == 0) continue;
      const uint says = verdict(camera, footprintOf(camera, origin + float(i) * step, half_size));
      empty[i] = says == kOutside;
      seen[i] += says == kInside ? 1 : 0;
      undecided[i] |= says == kUndecided ? 1u << index : 0;
    }
    uint open = 0;
    for (uint i = 0; i < kRun; ++i) open += empty[i] ? 0 : 1;
    if (subgroupOr(open) == 0) break;
  }

  if (idle) return;
  uvec4 share = uvec4(0);
  for (uint i = 0; i < kRun; ++i) {
    const uvec3 mine = corner + uvec3(i, 0, 0);
    const uvec3 low_voxel = mine * kSize;
    if (any(greaterThanEqual(low_voxel, uvec3(args.voxels)))) {  // past the cube's high side
      const uint bricks_edge = (args.voxels + kBrickVoxels - 1) / kBrickVoxels;
      if (all(lessThan(low_voxel / kBrickVoxels, uvec3(bricks_edge)))) writeUniform(mine, false);
      continue;
    }
    // whatever the undecided cameras find, fewer than two will see it
    const bool none = empty[i] || seen[i] + bitCount(undecided[i]) < 2;
    const bool cut = any(greaterThan(low_voxel + kSize, uvec3(args.voxels)));
    const bool full = !none && !cut && undecided[i] == 0;
    if (none || full) writeUniform(mine, full);
    else append(mine, undecided[i], seen[i]);
    if (full) share += fullShare(low_voxel, kSize);
  }
  addToSums(args.sums, share);
}
