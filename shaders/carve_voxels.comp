#version 460
// SPDX-License-Identifier: MIT
// The finest step: one invocation asks the undecided cameras about each of the 64 voxels of a mixed 4³ block.
#extension GL_GOOGLE_include_directive : require
#include "shaders/camera_io.h"
layout(constant_id = 1) const uint kLenses = 15;
#include "shaders/lens.glsl"
#include "shaders/occupancy.glsl"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { CarveVoxelArgs args; };

void main() {
  if (gl_GlobalInvocationID.x >= args.block_count.at[0].count) return;
  const MixedBlock block = args.blocks.at[gl_GlobalInvocationID.x];
  const uvec3 low_voxel =
      (uvec3(block.low_corner, block.low_corner >> 10, block.low_corner >> 20) & 1023u) * kBlockVoxels;
  const vec3 low_center = args.voxel_m * (vec3(low_voxel) + 0.5 - 0.5 * float(args.voxels));

  // One bit a voxel: still in every silhouette that sees it; seen by one camera at least; by two.
  uint alive[2] = {~0u, ~0u};
  uint once[2] = {block.seen >= 1 ? ~0u : 0u, block.seen >= 1 ? ~0u : 0u};
  uint twice[2] = {block.seen >= 2 ? ~0u : 0u, block.seen >= 2 ? ~0u : 0u};

  for (uint cameras = block.cameras; cameras != 0 && (alive[0] | alive[1]) != 0; cameras &= cameras - 1) {
    const GpuCamera camera = loadCamera(args.cameras, findLSB(cameras));
    const vec3 origin = camera.rotation * low_center + camera.translation;
    const mat3 step = camera.rotation * args.voxel_m;
    const vec2 size = vec2(camera.width, camera.height);
    for (uint half_index = 0; half_index < 2; ++half_index) {
      uint sees = 0, sets = 0;
      for (uint bit = 0; bit < 32; ++bit) {
        const vec3 voxel = vec3(bit & 3u, bit >> 2 & 3u, (bit >> 4) + 2 * half_index);
        const Projection projection = projectThroughLens(camera, origin + step * voxel);
        const vec2 shifted = projection.pixel + 0.5;
        if (projection.valid && all(greaterThanEqual(shifted, vec2(0))) && all(lessThan(shifted, size))) {
          const uvec2 pixel = uvec2(shifted);
          const uint word = args.masks.at[camera.mask_words + pixel.y * camera.row_words + (pixel.x >> 5)];
          sees |= 1u << bit;
          sets |= (word >> (pixel.x & 31u) & 1u) << bit;
        }
      }
      alive[half_index] &= sets | ~sees;
      twice[half_index] |= once[half_index] & sees;
      once[half_index] |= sees;
    }
  }

  // voxels behind the cube's high side, where N is no multiple of 4
  uint inside[2] = {~0u, ~0u};
  if (any(greaterThan(low_voxel + kBlockVoxels, uvec3(args.voxels))))
    for (uint bit = 0; bit < 64; ++bit) {
      const uvec3 voxel = low_voxel + uvec3(bit & 3u, bit >> 2 & 3u, bit >> 4);
      if (any(greaterThanEqual(voxel, uvec3(args.voxels)))) inside[bit >> 5] &= ~(1u << (bit & 31u));
    }

  const uint bricks_edge = (args.voxels + kBrickVoxels - 1) / kBrickVoxels;
  const uint word = blockWord(low_voxel, bricks_edge);
  args.words.at[word] = alive[0] & twice[0] & inside[0];
  args.words.at[word + 1] = alive[1] & twice[1] & inside[1];
}
