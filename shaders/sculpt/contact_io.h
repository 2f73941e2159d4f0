// SPDX-License-Identifier: MIT
// Contact in device memory: what is kept of each data point, the frame's state, and the kernels' arguments.
// The method is told in engine/sculpt/contact.h.
#ifndef AIRCLAY_CONTACT_IO_H
#define AIRCLAY_CONTACT_IO_H

#include "shaders/hand/fit_io.h"
#include "shaders/sculpt/symmetry_io.h"

AIRCLAY_IO_BEGIN

const uint kContactWorkgroup = 64;

// 0.2 mm outside, a reached point is released; less would let rounding reach and release it by turns.
const float kContactReleased = 0.0002;
// 1 mm outside, a point that was inside when tracking began has been left.
const float kContactLeft = 0.001;
// Steps along a path are at least this long: what is thinner than 0.5 mm may be missed …
const float kContactMinStep = 0.0005;
// … and on a longer path a share of it, so that there are at most so many steps.
const float kContactMaxSteps = 256;
// Where a path meets the surface is found to 2 µm.
const float kContactRefined = 2e-6;
// A point is looked for from this much above where it was.
const float kContactLift = 0.001;
// The surface is at most this far above that, else the point is left alone until the hand has left it.
const float kContactMaxClimb = 0.05;
// Of a unit normal added to the direction in each new frame.
const float kContactTurnToNormal = 0.5;
// Below this a way is too short to have a direction: the normal is taken.
const float kContactShortWay = 1e-6;

// What is left may be so deep; the repeats end.
const float kContactDepthWanted = 0.001;
// A repeat that leaves more than this share of the least depth so far does not shrink it; after so many in a
// row the repeats end.
const float kContactShrinks = 0.98;
const uint kContactMaxStalls = 3;
const uint kContactMaxRepeats = 32;
// The least Rayleigh quotient believed: 50 times over-relaxed at most.
const float kContactMinQuotient = 0.02;

const uint kPointOutside = 0;
const uint kPointReached = 1;
const uint kPointIgnored = 2;  // inside when tracking began, and not left yet

// A data point, or a mirror image of it, between two checks. Lengths along `direction` are in metres.
struct GpuContactPoint {
  vec3 position;  // at the last check, workspace
  uint state;
  vec3 direction;  // unit, outwards, hand's frame; of a reached point
  float depth;  // from the point to the hand's surface along it; negative: the surface lies behind, at most
                // `pushed`
  float depth_before;  // a check ago
  float pushed;        // all that the point was displaced by in this frame, for the solve
  float pushed_plain;  // that without momentum, see contact_push
  float last_push;     // by the last repeat
};

READ_POINTER(ReadContactPoints, GpuContactPoint)
READ_WRITE_POINTER(ReadWriteContactPoints, GpuContactPoint)

// Workgroups of an indirect dispatch.
struct GpuGroups {
  uint x;
  uint y;
  uint z;
};

// The hand: its distances, sampled on a grid. Last among arguments: C++ pads a struct's end, GLSL does not.
struct HandDistances {
  ReadFloats values;  // metres, negative inside
  vec3 low_corner;    // from the centre of gravity, hand's frame
  float cell_m;
  uint size_x;
  uint size_y;
  uint size_z;
};

const uint kFrameIdle = 0;   // nothing to do: no hand, or the clutch is open
const uint kFrameStart = 1;  // the first tracked frame: points inside are marked or gripped, nothing moves
const uint kFrameSweep = 2;

// The frame: the hand's two poses, how the repeats go, and the workgroups of what is to be done next.
struct GpuContactFrame {
  vec4 rotation_before;  // workspace_from_hand, a unit quaternion x y z w
  vec4 rotation_now;
  vec3 position_before;  // of the centre of gravity, workspace, metres
  vec3 position_now;
  vec4 rotation_gripped;  // when the hand took hold, see grip_io.h
  vec3 position_gripped;
  uint gripped;  // 1: it has taken hold
  uint mode;
  uint known;  // 1: the hand's pose in the next frame's `before` will be this frame's `now`
  uint done;
  uint touched;    // data points that are reached, each image counted
  uint repeats;    // solves done in this frame
  uint stalls;     // repeats in a row that did not shrink the depth
  float depth_m;   // the largest left
  float least_m;   // of all repeats of this frame
  float quotient;  // the largest Rayleigh quotient met; 0: none yet
  float step;      // of the next push
  float momentum;
  float theta;               // Nesterov's sequence
  GpuGroups find_groups;     // contact_find: in z the images
  GpuGroups point_groups;    // contact_push, subdivide and their like
  GpuGroups project_groups;  // solve_project
  GpuGroups apply_groups;    // solve_apply
  GpuGroups check_groups;    // contact_check
  GpuGroups normal_groups;   // normals, once at the end
};

READ_POINTER(ReadContactFrames, GpuContactFrame)
READ_WRITE_POINTER(ReadWriteContactFrames, GpuContactFrame)

// What comes back to the host.
struct GpuContactSummary {
  uint touched;
  uint repeats;
  float depth_m;
  uint done;
};

WRITE_POINTER(WriteContactSummaries, GpuContactSummary)

// The workgroup counts of the kernels that are repeated.
struct ContactGroups {
  uint points_x;
  uint points_y;
  uint project;
  uint apply;
  uint images;  // of each point that is looked at on its own
};

// What a check needs to tell whether to go on: contact_decide.glsl. Last among arguments.
struct ContactDecision {
  ReadWriteContactFrames frame;
  WriteContactSummaries summary;
  ContactGroups groups;
  float target_m;  // what is left may be so much; the repeats end
  uint max_repeats;
  uint max_stalls;  // repeats in a row that did not shrink it; the repeats end
};

// contact_begin: one invocation; what kind of frame this is.
struct ContactBeginArgs {
  ReadFits fit;
  ReadWriteContactFrames frame;
  vec4 clay_from_workspace;  // the clay may be turned; a unit quaternion x y z w
  ContactGroups groups;
  uint held;    // the clutch
  uint forget;  // 1: the last pose holds no more
};

// contact_find: one invocation a data point and image; depths along the points' directions. Image k of data
// point i stands in `points` at k * data_point_count + i.
struct ContactFindArgs {
  ReadContactFrames frame;
  ReadVec3s data_points;
  ReadWriteContactPoints points;
  uint mirrors;  // symmetry_io.h
  uint data_point_count;
  uint first;  // 1: the hand moves from `before` to `now`; 0: it stays and the clay has moved
  HandDistances hand;
};

// contact_check: one workgroup; whether to go on, and how far to push.
struct ContactCheckArgs {
  ReadContactPoints points;
  uint point_count;  // all images
  ContactDecision decision;
};

// contact_push: one invocation a data point; the displacements that the solve is to bring about.
struct ContactPushArgs {
  ReadContactFrames frame;
  ReadWriteContactPoints points;
  WriteVec3s displacements;  // workspace, metres
  uint data_point_count;
  uint mirrors;
};

AIRCLAY_IO_END

#endif
