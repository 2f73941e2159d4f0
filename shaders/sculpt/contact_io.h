// SPDX-License-Identifier: MIT
// Contact in device memory: the state of each data point, the state of the frame, and the kernels' arguments.
// See engine/sculpt/contact.h for the method.
#ifndef AIRCLAY_CONTACT_IO_H
#define AIRCLAY_CONTACT_IO_H

#include "shaders/hand/hand_pose_io.h"
#include "shaders/sculpt/symmetry_io.h"

AIRCLAY_IO_BEGIN

const uint kContactWorkgroup = 64;

// A reached point is released 0.2 mm outside; with less, rounding would reach and release it alternately.
const float kContactReleaseDistance = 0.0002;
// 1 mm outside, a point that was inside when tracking began counts as left.
const float kContactLeaveDistance = 0.001;
// Steps along a path are at least this long: anything thinner than 0.5 mm may be missed …
const float kContactMinStep = 0.0005;
// … and on a longer path a fraction of its length, which limits the number of steps.
const float kContactMaxSteps = 256;
// The intersection of a path with the surface is found to 2 µm.
const float kContactTolerance = 2e-6;
// The search for a point starts this far above its last position.
const float kContactLift = 0.001;
// The surface is at most this far above that; otherwise the point is ignored until the hand has left it.
const float kContactMaxClimb = 0.05;
// Fraction of the unit normal added to the direction in each new frame.
const float kContactTurnToNormal = 0.5;
// A path shorter than this has no direction: the normal is used.
const float kContactMinPath = 1e-6;

// The repeats end at this remaining depth.
const float kContactTargetDepth = 0.001;
// A repeat that leaves more than this fraction of the smallest depth so far counts as a stall; after a number
// of stalls in a row the repeats end.
const float kContactShrinks = 0.98;
const uint kContactMaxStalls = 3;
const uint kContactMaxRepeats = 32;
// The smallest accepted Rayleigh quotient: at most 50 times over-relaxed.
const float kContactMinQuotient = 0.02;

const uint kPointOutside = 0;
const uint kPointReached = 1;
const uint kPointIgnored = 2;  // inside when tracking began, and not yet left

// A data point, or a mirror image of it, between two checks. Lengths along `direction` are in metres.
struct GpuContactPoint {
  vec3 position;  // at the last check, workspace
  uint state;
  vec3 direction;  // unit, outwards, hand frame; of a reached point
  float depth;  // from the point to the hand's surface along it; negative: the surface is behind, by at most
                // `pushed`
  float depth_before;  // at the previous check
  float pushed;        // total displacement requested in this frame, for the solve
  float pushed_plain;  // the same without momentum, see contact_push
  float last_push;     // by the last repeat
};

READ_POINTER(ReadContactPoints, GpuContactPoint)
READ_WRITE_POINTER(ReadWriteContactPoints, GpuContactPoint)

// Workgroup counts of an indirect dispatch.
struct GpuGroups {
  uint x;
  uint y;
  uint z;
};

// The hand's distances, sampled on a grid. Must be the last argument: C++ pads a struct's end, GLSL does not.
struct HandDistances {
  ReadFloats values;  // metres, negative inside
  vec3 low_corner;    // from the centre of gravity, hand frame
  float cell_m;
  uint size_x;
  uint size_y;
  uint size_z;
};

const uint kFrameIdle = 0;   // nothing to do: no hand, or the clutch is open
const uint kFrameStart = 1;  // the first tracked frame: points inside are marked or gripped, nothing moves
const uint kFrameSweep = 2;

// The frame: the hand's two poses, the progress of the repeats, and the workgroup counts of the next kernels.
struct GpuContactFrame {
  vec4 rotation_before;  // workspace_from_hand, a unit quaternion x y z w
  vec4 rotation_now;
  vec3 position_before;  // of the centre of gravity, workspace, metres
  vec3 position_now;
  vec4 rotation_gripped;  // when the hand gripped, see grip_io.h
  vec3 position_gripped;
  uint gripped;  // 1: the hand has gripped
  uint mode;
  uint known;  // 1: the hand's pose becomes the next frame's `before`
  uint done;
  uint touched;    // reached data points, each image counted
  uint repeats;    // solves done in this frame
  uint stalls;     // repeats in a row that did not shrink the depth
  float depth_m;   // the largest that remains
  float least_m;   // smallest of all repeats of this frame
  float quotient;  // the largest Rayleigh quotient so far; 0: none yet
  float step;      // of the next push
  float momentum;
  float theta;               // Nesterov's sequence
  GpuGroups find_groups;     // contact_find: z counts the images
  GpuGroups point_groups;    // contact_push, subdivide and similar kernels
  GpuGroups project_groups;  // solve_project
  GpuGroups apply_groups;    // solve_apply
  GpuGroups check_groups;    // contact_check
  GpuGroups normal_groups;   // normals, once at the end
};

READ_POINTER(ReadContactFrames, GpuContactFrame)
READ_WRITE_POINTER(ReadWriteContactFrames, GpuContactFrame)

// The result for the host.
struct GpuContactSummary {
  uint touched;
  uint repeats;
  float depth_m;
  uint done;
};

WRITE_POINTER(WriteContactSummaries, GpuContactSummary)

// The workgroup counts of the repeated kernels.
struct ContactGroups {
  uint points_x;
  uint points_y;
  uint project;
  uint apply;
  uint images;  // images of each point that are processed separately
};

// A check's input for the decision to continue: contact_decide.glsl. Must be the last argument.
struct ContactDecision {
  ReadWriteContactFrames frame;
  WriteContactSummaries summary;
  ContactGroups groups;
  float target_m;  // the repeats end at this remaining depth
  uint max_repeats;
  uint max_stalls;  // the repeats end after this many stalls in a row
};

// contact_begin: one invocation; selects the frame's mode.
struct ContactBeginArgs {
  ReadHandPoses hand;
  ReadWriteContactFrames frame;
  vec4 clay_from_workspace;  // the clay may be rotated; a unit quaternion x y z w
  ContactGroups groups;
  uint held;    // the clutch
  uint forget;  // 1: the last pose is no longer valid
};

// contact_find: one invocation per data point and image; depths along the points' directions. Image k of data
// point i is `points` element k * data_point_count + i.
struct ContactFindArgs {
  ReadContactFrames frame;
  ReadVec3s data_points;
  ReadWriteContactPoints points;
  uint mirrors;  // symmetry_io.h
  uint data_point_count;
  uint first;  // 1: the hand moves from `before` to `now`; 0: it stays and the clay has moved
  HandDistances hand;
};

// contact_check: one workgroup; whether to continue, and how far to push.
struct ContactCheckArgs {
  ReadContactPoints points;
  uint point_count;  // all images
  ContactDecision decision;
};

// contact_push: one invocation per data point; target displacements for the solve.
struct ContactPushArgs {
  ReadContactFrames frame;
  ReadWriteContactPoints points;
  WriteVec3s displacements;  // workspace, metres
  uint data_point_count;
  uint mirrors;
};

AIRCLAY_IO_END

#endif
