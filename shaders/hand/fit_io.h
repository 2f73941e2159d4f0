// SPDX-License-Identifier: MIT
// The fit of the skeletal model to the voxel model, eq. (1) and (2), in device memory.
#ifndef AIRCLAY_FIT_IO_H
#define AIRCLAY_FIT_IO_H

#include "shaders/hand/hand_pose_io.h"
#include "shaders/hull/distance_io.h"

AIRCLAY_IO_BEGIN

// A triangle patch of the skin, relative to the model's centre of gravity (the origin in the paper's fig. 3),
// in the axes of the hand frame.
struct GpuPatch {
  vec3 center;  // of the triangle, metres
  float area;   // m²
  vec3 normal;  // unit, outwards
  uint cut;     // 1: not skin, but the cut where the forearm continues
};

READ_POINTER(ReadPatches, GpuPatch)

const uint kFitIncluded = 0;
const uint kFitStalled = 1;
const uint kFitOutOfIterations = 2;

// A start pose and the fit's result. The fit moves the root; the joint angles stay as given.
struct GpuFit {
  GpuHandPose pose;
  float outside_m;         // how far outside the patches are on average, weighted by area
  float outside_fraction;  // fraction of the patches that are outside
  uint outside_count;
  uint iterations;
  uint outcome;
};

READ_POINTER(ReadFits, GpuFit)
READ_WRITE_POINTER(ReadWriteFits, GpuFit)
WRITE_POINTER(WriteFits, GpuFit)

// fit: one workgroup per hypothesis, all iterations.
struct FitArgs {
  ReadPatches patches;
  ReadUlongs distances;  // see distance_io.h
  ReadWriteFits fits;
  vec3 field_low;  // the first cell's centre, metres
  float cell_m;
  vec3 inertia_low;   // of the inertia about the centre of gravity over the mass, hand frame: xx yy zz (m²)
  float patch_area;   // of all patches
  vec3 inertia_high;  // xy xz yz
  float margin_m;     // a patch is pushed from this far inside the surface
  uint field_size[3];
  uint patch_count;
  uint max_iterations;
};

// fit_choose: the best hypothesis becomes the frame's result, with a flag whether it is reliable.
struct FitChooseArgs {
  ReadFits fits;
  ReadHullSums hull;
  WriteFits result;
  WriteHandPoses hand;  // the result's pose
  uint count;
  uint min_occupied;     // voxels: fewer cannot be a hand
  float lost_outside_m;  // if the patches are farther outside than this on average, the fit has failed
};

AIRCLAY_IO_END

#endif
