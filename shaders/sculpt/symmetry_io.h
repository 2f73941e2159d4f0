// SPDX-License-Identifier: MIT
// Symmetry in device memory: everything the hand does is mirrored. See engine/sculpt/symmetry.h for the
// method.
#ifndef AIRCLAY_SYMMETRY_IO_H
#define AIRCLAY_SYMMETRY_IO_H

#include "shaders/clay/solve_io.h"

AIRCLAY_IO_BEGIN

// The images are packed into one uint, `mirrors`, 4 bits each: 1, 2, 4 for the axes x, y, z whose sign is
// flipped. Image 0 flips none; unused bits after the last image are 0.
const uint kMaxImages = 8;

const uint kSymmetryWorkgroup = 64;

// symmetry_average: one invocation per orbit, a set of control points that are each other's images.
struct SymmetryAverageArgs {
  ReadUints orbits;  // imageCount(mirrors) control points each, in the images' order
  ReadWriteDoubles exact_points;
  WriteVec3s control_points;
  uint orbit_count;
  uint mirrors;
};

AIRCLAY_IO_END

#endif
