// SPDX-License-Identifier: MIT
// Smoothing in device memory: clay near the hand relaxes. See engine/sculpt/relax.h for the method.
#ifndef AIRCLAY_RELAX_IO_H
#define AIRCLAY_RELAX_IO_H

#include "shaders/sculpt/contact_io.h"

AIRCLAY_IO_BEGIN

// The default reach: nothing relaxes 10 mm from the skin, and the effect grows towards it, over a finger's
// width.
const float kRelaxReach_m = 0.01;

// Steps per frame. A step removes at most all of the roughest shape, and a hundredth of that from one four
// times as long.
const uint kRelaxRepeats = 4;

// Displacements below a thousandth of a millimetre do not count.
const float kRelaxMinStep_m = 1e-6;

// relax_umbrella: one invocation per data point; the vector to the average of its neighbours, which are
// `neighbours` from starts[i] up to, not including, starts[i + 1].
struct RelaxUmbrellaArgs {
  ReadVec3s data_points;
  ReadVec3s normals;
  ReadUints starts;
  ReadUints neighbours;
  ReadUints borders;     // as in RelaxMoveArgs
  WriteVec3s umbrellas;  // along the normal, across the border, 0
  uint data_point_count;
};

// relax_move: one invocation per data point; target displacements for the solve.
struct RelaxMoveArgs {
  ReadContactFrames frame;
  ReadVec3s data_points;
  ReadVec3s normals;
  ReadVec3s umbrellas;  // written by relax_umbrella
  ReadUints starts;
  ReadUints neighbours;
  ReadUints borders;         // 1: on the surface's border; then the two neighbours are those along it
  WriteVec3s displacements;  // workspace, metres
  uint data_point_count;
  uint mirrors;  // symmetry_io.h
  float strength;
  float reach_m;
  HandDistances hand;
};

// relax_check: one workgroup; whether there is anything to do.
struct RelaxCheckArgs {
  ReadVec3s displacements;
  uint data_point_count;
  ContactDecision decision;
};

AIRCLAY_IO_END

#endif
