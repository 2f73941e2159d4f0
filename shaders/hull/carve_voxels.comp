#version 460
// SPDX-License-Identifier: MIT
// The finest step: one invocation tests each of the 64 voxels of a mixed 4³ block against the undecided cameras.
#extension GL_GOOGLE_include_directive : require
#include "shaders/camera/camera_io.h"
layout(constant_id = 1) const uint kLenses = 15;
layout(constant_id = 2) const uint kLanes = 1;
#include "shaders/camera/lens.glsl"
#include "shaders/camera/load_camera.glsl"
#include "shaders/hull/footprint.glsl"
#include "shaders/hull/hull_sums.glsl"
#include "shaders/hull/occupancy.glsl"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { CarveVoxelArgs args; };

READ_POINTER(ReadPairs, uint64_t)

// The verdicts of the cameras so far, one bit per voxel.
uint alive[2];  // inside every silhouette whose camera sees it
uint once[2];   // seen by at least one camera
uint twice[2];  // by at least two

void addView(uint half_index, uint sees, uint sets) {
  alive[half_index] &= sets | ~sees;
  twice[half_index] |= once[half_index] & sees;
  once[half_index] |= sees;
}

vec3 voxelAt(uint half_index, uint bit) { return vec3(bit & 3u, bit >> 2 & 3u, (bit >> 4) + 2 * half_index); }

// The part of a mask that a block's footprint covers, one word per row, loaded once: lavapipe reads an invocation's own array five times
// faster than a buffer.
const uint kWindowPixels = 32;  // along an edge
uint window[kWindowPixels];

void loadWindow(GpuCamera camera, uvec2 low, uint rows) {
  const uint first = min(low.x / 32, camera.row_words - 2);  // of the two words that contain a row's part
  for (uint row = 0; row < rows; ++row) {
    const uint word = camera.mask_words + (low.y + row) * camera.row_words + first;
    window[row] = uint(ReadPairs(uint64_t(args.masks) + 4ul * word).at[0] >> (low.x - 32 * first));
  }
}

// Tests a camera that sees the whole block. `origin` is the lowest voxel's centre, in camera coordinates; `step` leads to the next along
// each axis.
void testThroughWindow(GpuCamera camera, Footprint footprint, vec3 origin, mat3 step) {
  const uvec2 low = pixelAt(footprint.low);
  loadWindow(camera, low, pixelAt(footprint.high).y - low.y + 1);
  for (uint half_index = 0; half_index < 2; ++half_index) {
    uint sets = 0;
    for (uint row = 0; row < 8; ++row) {
      const vec3 first = origin + step * voxelAt(half_index, 4 * row);
      for (uint x = 0; x < 4; ++x) {
        const Projection projection = projectThroughLens(camera, first + float(x) * step[0]);
        const uvec2 pixel = min(pixelAt(projection.pixel) - low, kWindowPixels - 1);
        sets |= (window[pixel.y] >> pixel.x & 1u) << (4 * row + x);
      }
    }
    addView(half_index, ~0u, sets);
  }
}

// Tests any camera.
void test(GpuCamera camera, vec3 origin, mat3 step) {
  const vec2 size = vec2(camera.width, camera.height);
  for (uint half_index = 0; half_index < 2; ++half_index) {
    uint sees = 0, sets = 0;
    for (uint bit = 0; bit < 32; ++bit) {
      const Projection projection = projectThroughLens(camera, origin + step * voxelAt(half_index, bit));
      const vec2 at = projection.pixel;
      if (projection.valid && all(greaterThanEqual(at, vec2(-0.5))) && all(lessThan(at, size - 0.5))) {
        const uvec2 pixel = pixelAt(at);
        const uint word = args.masks.at[camera.mask_words + pixel.y * camera.row_words + (pixel.x >> 5)];
        sees |= 1u << bit;
        sets |= (word >> (pixel.x & 31u) & 1u) << bit;
      }
    }
    addView(half_index, sees, sets);
  }
}

void main() {
  const bool idle = gl_GlobalInvocationID.x >= args.block_count.at[0].count;  // idle invocations still help to load cameras
  MixedBlock block = MixedBlock(0, 0, 0);
  if (!idle) block = args.blocks.at[gl_GlobalInvocationID.x];
  const uvec3 low_voxel =
      (uvec3(block.low_corner, block.low_corner >> 10, block.low_corner >> 20) & 1023u) * kBlockVoxels;
  const vec3 low_center = args.voxel_m * (vec3(low_voxel) + 0.5 - 0.5 * float(args.voxels));
  const float half_size = args.voxel_m * (0.5 * float(kBlockVoxels - 1));

  for (uint half_index = 0; half_index < 2; ++half_index) {
    alive[half_index] = ~0u;
    once[half_index] = block.seen >= 1 ? ~0u : 0u;
    twice[half_index] = block.seen >= 2 ? ~0u : 0u;
  }
  for (uint cameras = subgroupOr(block.cameras); cameras != 0; cameras &= cameras - 1) {
    const uint index = findLSB(cameras);
    const GpuCamera camera = loadCamera(args.cameras, index);
    if ((block.cameras >> index & 1u) != 0 && (alive[0] | alive[1]) != 0) {
      const vec3 origin = camera.rotation * low_center + camera.translation;
      const mat3 step = camera.rotation * args.voxel_m;
      const Footprint footprint = footprintOf(camera, origin + camera.rotation * vec3(half_size), half_size);
      const uvec2 extent = pixelAt(footprint.high) - pixelAt(footprint.low);
      if (footprint.seen == kWholeSeen && all(lessThan(extent, uvec2(kWindowPixels)))) testThroughWindow(camera, footprint, origin, step);
      else test(camera, origin, step);
    }
  }
  if (idle) return;

  // voxels past the cube's high side, if N is not a multiple of 4
  uint inside[2] = {~0u, ~0u};
  if (any(greaterThan(low_voxel + kBlockVoxels, uvec3(args.voxels))))
    for (uint bit = 0; bit < 64; ++bit) {
      const uvec3 voxel = low_voxel + uvec3(bit & 3u, bit >> 2 & 3u, bit >> 4);
      if (any(greaterThanEqual(voxel, uvec3(args.voxels)))) inside[bit >> 5] &= ~(1u << (bit & 31u));
    }

  const uint bricks_edge = (args.voxels + kBrickVoxels - 1) / kBrickVoxels;
  const uint word = blockWord(low_voxel, bricks_edge);
  const uint low_word = alive[0] & twice[0] & inside[0], high_word = alive[1] & twice[1] & inside[1];
  args.words.at[word] = low_word;
  args.words.at[word + 1] = high_word;
  addToSums(args.sums, wordsShare(low_voxel, low_word, high_word));
}
