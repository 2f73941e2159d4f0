// SPDX-License-Identifier: MIT
// Signed distance to the voxel model on a small cube of cells around the hand: how far outside a patch is.
#ifndef AIRCLAY_DISTANCE_IO_H
#define AIRCLAY_DISTANCE_IO_H

#include "shaders/carve_io.h"

AIRCLAY_IO_BEGIN

// Cells along an edge. 64 cells of 4.7 mm hold a hand of 22 cm and 4 cm around it; a row is two words.
const uint kFieldCells = 64;
const uint kFieldSize = kFieldCells * kFieldCells * kFieldCells;
// Distances are exact up to this many cells, and cut off there: 47 mm, more than a hand moves between two frames.
const int kFieldReach = 10;
// Inside, forces end within a cell of the surface.
const int kFieldInnerReach = 3;
const uint kFieldFar = 16000;  // squared cells: above any square that occurs
const uint kFieldWorkgroup = 64;

// Where the cube of cells lies. A cell is `stride` voxels wide and takes the voxel at its middle.
struct FieldPlace {
  int low[3];   // voxel index of the low corner; may lie outside the model, which is empty there
  uint stride;  // voxels a cell
};

// distance_rows: along x, from the voxels. distance_lines: along y (step kFieldCells), then z (step kFieldCells²).
// Between the passes a cell is two squared distances in cells: to the nearest occupied cell in the low 16 bits, to the nearest empty
// one in the high. The last pass writes metres: positive outside.
struct DistanceRowArgs {
  ReadUints brick_states;
  ReadUints words;
  WriteUints squares;
  FieldPlace place;
  uint voxels;
};

struct DistanceLineArgs {
  ReadUints squares;
  WriteUints next_squares;  // the pass along y
  WriteFloats distances;    // the pass along z; 0 in the other
  uint axis_step;
  float cell_m;
};

AIRCLAY_IO_END

#endif
