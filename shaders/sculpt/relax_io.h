// SPDX-License-Identifier: MIT
// Smoothing in device memory: clay near the hand relaxes. The method is told in engine/sculpt/relax.h.
#ifndef AIRCLAY_RELAX_IO_H
#define AIRCLAY_RELAX_IO_H

#include "shaders/sculpt/contact_io.h"

AIRCLAY_IO_BEGIN

// The default reach: nothing relaxes 10 mm from the skin, and the effect grows towards it, over a finger's width.
const float kRelaxReach_m = 0.01;

// Steps in a frame. A step takes at most all of the roughest shape, and of one four times as long a hundredth
// of that.
const uint kRelaxRepeats = 4;

// Displacements below a thousandth of a millimetre do not count.
const float kRelaxLeast_m = 1e-6;

// relax_umbrella: one invocation a data point; the way to the average of its neighbours. These stand in
// `neighbours` from starts[i] up to starts[i + 1].
struct RelaxUmbrellaArgs {
  ReadVec3s data_points;
  ReadVec3s normals;
  ReadUints starts;
  ReadUints neighbours;
  ReadUints borders;     // as relax_move's
  WriteVec3s umbrellas;  // along the normal, across the border, 0
  uint data_point_count;
};

// relax_move: one invocation a data point; the displacements that the solve is to bring about.
struct RelaxMoveArgs {
  ReadContactFrames frame;
  ReadVec3s data_points;
  ReadVec3s normals;
  ReadVec3s umbrellas;  // relax_umbrella's
  ReadUints starts;
  ReadUints neighbours;
  ReadUints borders;         // 1: on the surface's border, where the two neighbours are those along it
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
