// SPDX-License-Identifier: MIT
// Signed distance to the voxel model on a box of cells around the hand: how far outside a patch is.
#ifndef AIRCLAY_DISTANCE_IO_H
#define AIRCLAY_DISTANCE_IO_H

#include "shaders/hull/carve_io.h"

AIRCLAY_IO_BEGIN

// Maximum number of cells along an edge: a row's occupancy is one word of 64 bits, and each of its eight-cell
// groups one word of bytes.
const uint kFieldCells = 64;
const uint kFieldSize = kFieldCells * kFieldCells * kFieldCells;
const uint kGroup = 8;  // cells whose squared distances share a word, one byte each
// Distances are exact up to this many cells and clamped there: 33 mm outside, more than a hand moves between
// two frames. Its square leaves room in seven bits for a sum of two.
const int kFieldReach = 7;
// Inside, forces end within a cell of the surface.
const int kFieldInnerReach = 3;
const uint kFieldWorkgroup = 64;
// Cells along a line that one invocation computes, loading each input once.
const uint kFieldRun = 8;

// The position of the box of cells. A cell is `stride` voxels wide and samples the voxel at its middle. Sizes
// are multiples of 8.
struct FieldPlace {
  int low[3];    // voxel index of the low corner, a multiple of 8; may be outside the model, which is empty
                 // there
  uint size[3];  // cells
  uint stride;   // voxels per cell
};

// Intermediate squared distances are bytes, in cells: first those to the nearest occupied cell, then those to
// the nearest empty one. A plane's group (x / 8, y, z) is word x / 8 + size_x / 8 · (y + size_y · z).
// distance_rows works along x, from the voxels; distance_lines along y, then z: the exact Euclidean transform
// is separable (Saito and Toriwaki 1994). The pass along z writes metres, positive outside: for each cell its
// own value and its upper neighbour's, so that an interpolation needs four loads.
struct DistanceRowArgs {
  ReadUints brick_states;
  ReadUints words;
  WriteUlongs squares;
  FieldPlace place;
  uint voxels;
};

struct DistanceLineArgs {
  ReadUlongs squares;
  WriteUlongs next_squares;  // the pass along y
  WriteUlongs distances;     // the pass along z: two floats per entry
  uint groups;               // per plane
  uint step;                 // groups from a cell to the next along the line
  uint line_cells;
  float cell_m;
};

AIRCLAY_IO_END

#endif
