// SPDX-License-Identifier: MIT
// Drawing the voxel model: kernels list the voxels of its surface in an order that is the same on every
// device; each is drawn as a cube.
#ifndef AIRCLAY_RENDERER_VOXELS_IO_H
#define AIRCLAY_RENDERER_VOXELS_IO_H

#include "shaders/hull/carve_io.h"
#include "shaders/render/renderer_io.h"

AIRCLAY_IO_BEGIN

const uint kVoxelVertices = 18;  // the three faces that can be visible at once
const uint kVoxelScanWorkgroup = 64;

// The number of voxels that are drawn and lit, in the layout of indirect commands.
struct VoxelCounts {
  uint vertices;
  uint instances;
  uint first_vertex;
  uint first_instance;
  uint groups_x;  // of the lighting kernel
  uint groups_y;
  uint groups_z;
};
READ_POINTER(ReadVoxelCounts, VoxelCounts)
WRITE_POINTER(WriteVoxelCounts, VoxelCounts)

// render_voxel_list.comp, one invocation per brick. Constant 1: 0 counts the surface voxels, 1 writes them.
struct VoxelListArgs {
  ReadUints brick_states;
  ReadUints words;
  ReadUints firsts;      // each brick's first index in the list; only when writing
  WriteUints counts;     // of each brick; only when counting
  WriteVec3s positions;  // centres
  WriteVec3s normals;    // unit, from the occupancy of the voxels around
  uint voxels;
  uint bricks_edge;
  float voxel_m;
  uint capacity;
};

// render_voxel_scan.comp, one workgroup: each brick's first index in the list, and the total.
struct VoxelScanArgs {
  ReadUints counts;
  WriteUints firsts;
  WriteVoxelCounts totals;
  uint brick_count;
  uint capacity;
};

// render_voxels.vert, .frag
struct RenderVoxelArgs {
  ReadVec3s positions;
  ReadVertexLights lights;  // 0: depth only
  mat4 clip_from_workspace;
  vec3 eye;  // the faces that point towards it are drawn
  vec3 key_direction;
  vec3 albedo;
  float voxel_m;
};

AIRCLAY_IO_END

#endif
