#version 460
// SPDX-License-Identifier: MIT
// Coarse to fine: one invocation classes one block as empty, full or mixed, by what every camera says of the ball around it.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "shaders/lens.glsl"
#include "shaders/occupancy.glsl"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint kSize = 8;  // voxels along a block's edge: 32, 8 or 4
layout(push_constant, scalar) uniform Push { CarveBlockArgs args; };

// What a camera says of a block as a whole.
const uint kUnseen = 0;     // no voxel of it is seen
const uint kOutside = 1;    // all is seen, nothing in the silhouette
const uint kInside = 2;     // all is seen, all in the silhouette
const uint kUndecided = 3;

uint tableSum(uint at, uint stride, uvec2 low, uvec2 high) {
  return args.tables.at[at + high.y * stride + high.x] - args.tables.at[at + low.y * stride + high.x] -
         args.tables.at[at + high.y * stride + low.x] + args.tables.at[at + low.y * stride + low.x];
}

// `center` in camera coordinates; all voxel centres of the block lie within `radius` of it (metres).
uint verdict(GpuCamera camera, vec3 center, float radius) {
  if (center.z <= -radius) return kUnseen;
  if (center.z <= radius) return kUndecided;

  // How far from the centre's direction the others lie: as a change of the undistorted position.
  float position, deviation;
  if (camera.lens == kLensFisheye) {
    position = atan(length(center.xy), center.z);
    deviation = asin(min(radius / length(center), 1.0));
  } else {
    // (x + δx) / (z + δz) - x / z = (δx - x/z δz) / (z + δz), |δ| <= radius
    position = length(center.xy) / center.z;
    deviation = radius * sqrt(1 + position * position) / (center.z - radius);
  }
  if (position - deviation > camera.visible) return kUnseen;
  if (position + deviation > min(camera.limit, 1.1 * camera.visible)) return kUndecided;

  const vec2 pixel = projectThroughLens(camera, center).pixel;
  const vec2 reach = camera.focal * (camera.steepness * deviation) + 0.01;  // float's rounding, generously
  const vec2 low = pixel - reach, high = pixel + reach;
  const vec2 size = vec2(camera.width, camera.height);
  if (any(lessThan(high, vec2(-0.5))) || any(greaterThanEqual(low, size - 0.5))) return kUnseen;
  const bool whole = all(greaterThanEqual(low, vec2(-0.5))) && all(lessThan(high, size - 0.5));
  if (!whole) return kUndecided;

  const uvec2 first = uvec2(floor(low + 0.5)) / camera.tile;
  const uvec2 end = uvec2(floor(high + 0.5)) / camera.tile + 1;
  const uint stride = camera.tiles_x + 1;
  if (tableSum(camera.table_words, stride, first, end) == 0) return kOutside;
  const uint all_at = camera.table_words + stride * (camera.tiles_y + 1);
  const uvec2 extent = end - first;
  return tableSum(all_at, stride, first, end) == extent.x * extent.y ? kInside : kUndecided;
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

void main() {
  const uint children = args.children_edge * args.children_edge * args.children_edge;
  const uint parent_index = gl_GlobalInvocationID.x / children;
  const uint child = gl_GlobalInvocationID.x % children;
  const bool top = kSize == kTopVoxels;
  if (parent_index >= (top ? 1 : args.parent_count.at[0].count)) return;

  MixedBlock block;
  uvec3 parent_corner = uvec3(0);
  if (top) {
    block.cameras = args.camera_count == 32 ? ~0u : (1u << args.camera_count) - 1;
    block.seen = 0;
  } else {
    block = args.parents.at[parent_index];
    parent_corner = uvec3(block.low_corner, block.low_corner >> 10, block.low_corner >> 20) & 1023u;
  }
  const uvec3 corner = parent_corner * args.children_edge +
                       uvec3(child, child / args.children_edge, child / (args.children_edge * args.children_edge)) %
                           args.children_edge;
  const uvec3 low_voxel = corner * kSize;
  if (any(greaterThanEqual(low_voxel, uvec3(args.voxels)))) {  // behind the cube's high side
    const uint bricks_edge = (args.voxels + kBrickVoxels - 1) / kBrickVoxels;
    if (all(lessThan(low_voxel / kBrickVoxels, uvec3(bricks_edge)))) writeUniform(corner, false);
    return;
  }

  const vec3 center = args.voxel_m * (vec3(low_voxel) + 0.5 * float(kSize) - 0.5 * float(args.voxels));
  const float radius = args.voxel_m * (0.5 * float(kSize - 1)) * 1.7320508;
  uint undecided = 0, seen = block.seen;
  bool empty = false;
  for (uint cameras = block.cameras; cameras != 0 && !empty; cameras &= cameras - 1) {
    const uint index = findLSB(cameras);
    const GpuCamera camera = args.cameras.at[index];
    const uint says = verdict(camera, camera.rotation * center + camera.translation, radius);
    empty = says == kOutside;
    seen += says == kInside ? 1 : 0;
    undecided |= says == kUndecided ? 1u << index : 0;
  }
  // whatever the undecided ones find, fewer than two cameras will see it
  empty = empty || seen + bitCount(undecided) < 2;
  const bool cut = any(greaterThan(low_voxel + kSize, uvec3(args.voxels)));
  if (empty || (undecided == 0 && !cut)) {
    writeUniform(corner, !empty);
    return;
  }

  if (kSize == kBrickVoxels) {
    const uint bricks_edge = (args.voxels + kBrickVoxels - 1) / kBrickVoxels;
    args.brick_states.at[brickIndex(corner, bricks_edge)] = kBrickMixed;
  }
  // The list's order varies from run to run; what is written for each block does not.
  const uint slot = atomicAdd(args.mixed_count.at[0].count, 1);
  const uint invocations = (slot + 1) * args.grandchildren;
  atomicMax(args.mixed_count.at[0].groups_x, (invocations + kCarveWorkgroup - 1) / kCarveWorkgroup);
  args.mixed.at[slot] = MixedBlock(corner.x | corner.y << 10 | corner.z << 20, undecided, seen);
}
