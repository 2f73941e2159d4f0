// SPDX-License-Identifier: MIT
// The grip in device memory: clay that sticks to the hand. See engine/sculpt/grip.h for the method.
#ifndef AIRCLAY_GRIP_IO_H
#define AIRCLAY_GRIP_IO_H

#include "shaders/sculpt/contact_io.h"

AIRCLAY_IO_BEGIN

// The default reach, from the skin outwards: what looks touched, as voxels of 4.7 mm resolve no less and data
// points are about a centimetre apart. Points inside the hand are held too, or a hand deep in the clay would
// drag a hollow ring.
const float kGripReach_m = 0.006;

// The repeats end when gripped points lag by no more than this. A voxel is ten times as large.
const float kGripTargetLag_m = 0.0005;

// With momentum the lag decreases in waves, and the target is approached from either side: unlike with
// depths, more stalls are tolerated.
const uint kGripMaxStalls = 8;

// A data point while the hand grips.
struct GpuGripPoint {
  vec3 start;         // its position when the hand gripped, workspace
  uint images;        // bit k: image k of the hand grips it; 0: none does
  vec3 lag;           // from the point to its target
  float achieved;     // the last target displacement times the achieved one
  vec3 pulled;        // total displacement requested in this frame, for the solve
  vec3 pulled_plain;  // the same without momentum
  vec3 last_pull;     // by the last repeat
};

READ_POINTER(ReadGripPoints, GpuGripPoint)
READ_WRITE_POINTER(ReadWriteGripPoints, GpuGripPoint)

// grip_find: one invocation per data point; which points are gripped, and how far they lag behind.
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

// grip_check: one workgroup; whether to continue, and how far to pull.
struct GripCheckArgs {
  ReadGripPoints points;
  uint data_point_count;
  ContactDecision decision;
};

// grip_pull: one invocation per data point; target displacements for the solve.
struct GripPullArgs {
  ReadContactFrames frame;
  ReadWriteGripPoints points;
  WriteVec3s displacements;  // workspace, metres
  uint data_point_count;
};

AIRCLAY_IO_END

#endif
