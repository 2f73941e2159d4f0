// SPDX-License-Identifier: MIT
// The grip in device memory: clay that sticks to the hand. The method is told in engine/sculpt/grip.h.
#ifndef AIRCLAY_GRIP_IO_H
#define AIRCLAY_GRIP_IO_H

#include "shaders/sculpt/contact_io.h"

AIRCLAY_IO_BEGIN

// The default reach, from the skin outwards: what looks touched, as voxels of 4.7 mm resolve no less and data points
// are about a centimetre apart. Points inside the hand are held too, or a hand deep in the clay would drag a hollow
// ring.
const float kGripReach_m = 0.006;

// What held points may lag behind; the repeats end. A voxel is ten times as large.
const float kGripLagWanted_m = 0.0005;

// With momentum the lag goes down by waves, and where it is to end is reached from any side: patience pays,
// unlike with depths.
const uint kGripMaxStalls = 8;

// A data point while the hand holds on.
struct GpuGripPoint {
  vec3 start;         // where it was when the hand took hold, workspace
  uint images;        // bit k: image k of the hand holds it; 0: nobody does
  vec3 lag;           // from the point to where it is to be
  float achieved;     // the last displacement wanted times that which came of it
  vec3 pulled;        // all that it was displaced by in this frame, for the solve
  vec3 pulled_plain;  // that without momentum
  vec3 last_pull;     // by the last repeat
};

READ_POINTER(ReadGripPoints, GpuGripPoint)
READ_WRITE_POINTER(ReadWriteGripPoints, GpuGripPoint)

// grip_find: one invocation a data point; who is held, and how far it lags behind.
struct GripFindArgs {
  ReadContactFrames frame;
  ReadVec3s data_points;
  ReadWriteGripPoints points;
  uint data_point_count;
  uint mirrors;  // symmetry_io.h
  uint first;    // 1: the frame's first check
  float reach_m;
  HandDistances hand;
};

// grip_check: one workgroup; whether to go on, and how far to pull.
struct GripCheckArgs {
  ReadGripPoints points;
  uint data_point_count;
  ContactDecision decision;
};

// grip_pull: one invocation a data point; the displacements that the solve is to bring about.
struct GripPullArgs {
  ReadContactFrames frame;
  ReadWriteGripPoints points;
  WriteVec3s displacements;  // workspace, metres
  uint data_point_count;
};

AIRCLAY_IO_END

#endif
