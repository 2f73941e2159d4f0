// SPDX-License-Identifier: MIT
// Smoothing in device memory: clay near the hand relaxes. The method is told in engine/relax.h.
#ifndef AIRCLAY_RELAX_IO_H
#define AIRCLAY_RELAX_IO_H

#include "shaders/contact_io.h"

AIRCLAY_IO_BEGIN

// 10 mm from the skin nothing relaxes any more, and nearer ever more: a finger's width of transition.
const float kRelaxReach_m = 0.01;

// Less than a thousandth of a millimetre to do is nothing.
const float kRelaxLeast_m = 1e-6;

// relax_umbrella: one invocation a data point; the way to the average of its neighbours. These stand in `neighbours` from starts[i] up to starts[i + 1].
struct RelaxUmbrellaArgs {
  ReadVec3s data_points;
  ReadUints starts;
  ReadUints neighbours;
  WriteVec3s umbrellas;
  uint data_point_count;
};

// relax_move: one invocation a data point; the displacements that the solve is to bring about.
struct RelaxMoveArgs {
  ReadContactFrames frame;
  ReadVec3s data_points;
  ReadVec3s normals;
  ReadVec3s umbrellas;
  ReadUints starts;
  ReadUints neighbours;
  ReadUints borders;         // 1: on the surface's border, where the two neighbours are those along it
  WriteVec3s displacements;  // workspace, metres
  HandDistances hand;
  uint data_point_count;
  uint mirrors;  // symmetry_io.h
  float strength;
};

// relax_check: one workgroup; whether there is anything to do.
struct RelaxCheckArgs {
  ReadVec3s displacements;
  uint data_point_count;
  ContactDecision decision;
};

AIRCLAY_IO_END

#endif
