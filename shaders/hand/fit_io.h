// SPDX-License-Identifier: MIT
// The fit of the skeletal model to the voxel model, eq. (1) and (2), in device memory.
#ifndef AIRCLAY_FIT_IO_H
#define AIRCLAY_FIT_IO_H

#include "shaders/hull/distance_io.h"

AIRCLAY_IO_BEGIN

// A triangle patch of the skin, about the model's centre of gravity (the origin of the paper's fig. 3), axes
// of the hand's frame.
struct GpuPatch {
  vec3 center;  // of the triangle, metres
  float area;   // m²
  vec3 normal;  // unit, outwards
  uint cut;     // 1: not skin, but where the forearm continues
};

READ_POINTER(ReadPatches, GpuPatch)

const uint kFitIncluded = 0;
const uint kFitStalled = 1;
const uint kFitOutOfIterations = 2;

// A pose to start from, and what became of it. The centre of gravity's position is in the workspace's frame.
struct GpuFit {
  vec4 rotation;           // unit quaternion x y z w: workspace_from_hand
  vec3 position;           // metres
  float outside_m;         // how far outside the patches are on average, by area
  float outside_fraction;  // share of the patches that are outside
  uint outside_count;
  uint iterations;
  uint outcome;
  uint tracked;  // 1 when it is to be believed
};

READ_POINTER(ReadFits, GpuFit)
READ_WRITE_POINTER(ReadWriteFits, GpuFit)
WRITE_POINTER(WriteFits, GpuFit)

// fit: one workgroup a hypothesis, all iterations.
struct FitArgs {
  ReadPatches patches;
  ReadUlongs distances;  // as distance_io.h says
  ReadWriteFits fits;
  vec3 field_low;  // the first cell's centre, metres
  float cell_m;
  vec3 inertia_low;  // of the inertia about the centre of gravity over the mass, hand's frame: xx yy zz (m²)
  float patch_area;  // all patches
  vec3 inertia_high;  // xy xz yz
  float margin_m;     // a patch begins to be pushed this far inside the surface
  uint field_size[3];
  uint patch_count;
  uint max_iterations;
};

// fit_choose: the best of the hypotheses becomes the frame's result, and whether it is to be believed.
struct FitChooseArgs {
  ReadFits fits;
  ReadHullSums hull;
  WriteFits result;
  uint count;
  uint min_occupied;     // voxels: less is nobody's hand
  float lost_outside_m;  // patches farther outside than this on average: the model is not there
};

AIRCLAY_IO_END

#endif
