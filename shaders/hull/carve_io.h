// SPDX-License-Identifier: MIT
// The voxel model (the paper's fig. 1) in device memory, and the arguments of the kernels that carve it.
//
// Voxel (i, j, k) of N³ has its centre at (i + ½, j + ½, k + ½) · edge / N from the workspace's low corner.
// The model is stored brick by brick: 8³ voxels, each brick empty, full, or mixed. A mixed brick has 16
// words: its eight 4³ blocks in turn (x fastest), two words each; bit x + 4 y + 16 z of a block, the low word
// first.
#ifndef AIRCLAY_CARVE_IO_H
#define AIRCLAY_CARVE_IO_H

#include "shaders/camera/camera_io.h"

AIRCLAY_IO_BEGIN

const uint kBrickVoxels = 8;  // along an edge
const uint kBlockVoxels = 4;  // along an edge of the smallest block that is classified as a whole
const uint kTopVoxels = 32;   // along an edge of the largest
const uint kBrickWords = 16;

const uint kBrickEmpty = 0;
const uint kBrickFull = 1;
const uint kBrickMixed = 2;

// A block that is neither certainly empty nor certainly full.
struct MixedBlock {
  uint low_corner;  // in blocks of its size: x | y << 10 | z << 20
  uint cameras;     // bits of the cameras that are undecided about some of it
  uint seen;        // how many other cameras see all of it inside their silhouettes
};

READ_POINTER(ReadMixedBlocks, MixedBlock)
WRITE_POINTER(WriteMixedBlocks, MixedBlock)

// The number of mixed blocks, and the dispatch that processes their children; one for each block size, 32, 8
// and 4.
const uint kMixedSizes = 3;

struct MixedCount {
  uint groups_x;
  uint groups_y;
  uint groups_z;
  uint count;
};

READ_POINTER(ReadMixedCounts, MixedCount)
WRITE_POINTER(WriteMixedCounts, MixedCount)
READ_WRITE_POINTER(ReadWriteMixedCounts, MixedCount)

// Volume and centre of gravity as integers, so that the order in which blocks add to them does not matter
// (hull_sums.glsl).
struct HullSums {
  uint64_t occupied;       // voxels
  uint64_t index_sums[3];  // of x, y, z over the occupied voxels
};

READ_POINTER(ReadHullSums, HullSums)

const uint kHullSumWords = 8;  // kernels add words: for each number the low word first

// Maximum workgroup size: a software device uses one subgroup, so that its threads can share few blocks
// evenly.
const uint kCarveWorkgroup = 64;

// carve_tiles: for each tile of 4 x 4 pixels of each mask, whether any and whether all of its pixels are set;
// the same for large tiles of 16 x 16, which the topmost blocks use. A block's rectangle is then a few loads;
// summed-area tables would cost more to build than they save. An entry is 128 pixels of a row of tiles: `any`
// in its low word, `all` in its high one, the leftmost tile's bit lowest. Rows of entries come in bands of 16
// pixels: four rows of tiles, then one of large tiles. As the first kernel of a model, it resets the counters
// of the others.
const uint kTilePixels = 4;
const uint kLargeTilePixels = 16;
const uint kEntryPixels = 128;
const uint kBandRows = 5;  // of entries

struct CarveTileArgs {
  ReadCameras cameras;
  ReadUlongs masks;  // two words at a time
  WriteUlongs tiles;
  WriteMixedCounts mixed_counts;
  WriteUints sums;
};

// carve_blocks: classifies the children of mixed blocks; one invocation per run of children along x.
// Specialization constants: 1 voxels along a child's edge, 2 children in a run.
struct CarveBlockArgs {
  ReadCameras cameras;
  ReadUlongs tiles;
  ReadMixedBlocks parents;       // 0 at the top: one parent, the cube
  ReadMixedCounts parent_count;  // 0 at the top
  WriteMixedBlocks mixed;
  ReadWriteMixedCounts mixed_count;
  WriteUints brick_states;
  WriteUints words;
  ReadWriteUints sums;  // HullSums
  uint camera_bits;     // the cameras that take part: at the top
  uint voxels;          // N
  float voxel_m;
  uint runs_edge;         // runs along x in a parent
  uint children_edge;     // children along a parent's y and z
  uint next_invocations;  // invocations of the next kernel per child
};

// carve_voxels: decides every voxel of the mixed 4³ blocks.
struct CarveVoxelArgs {
  ReadCameras cameras;
  ReadUints masks;
  ReadMixedBlocks blocks;
  ReadMixedCounts block_count;
  WriteUints words;
  ReadWriteUints sums;  // HullSums
  uint voxels;
  float voxel_m;
};

AIRCLAY_IO_END

#endif
