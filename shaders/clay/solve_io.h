// SPDX-License-Identifier: MIT
// Eq. (6)-(8) over all rows in device memory: p += (AᵀA)⁺ (Aᵀ r), r the data points' target displacements.
#ifndef AIRCLAY_SOLVE_IO_H
#define AIRCLAY_SOLVE_IO_H

#include "shaders/core/io.h"

AIRCLAY_IO_BEGIN

READ_POINTER(ReadDoubles, double)
WRITE_POINTER(WriteDoubles, double)
READ_WRITE_POINTER(ReadWriteDoubles, double)

// Workgroup size of solve_apply.
const uint kSolveWorkgroup = 64;

// solve_project: Aᵀ r, one workgroup per control point. Column j's weights and data points are at
// column_starts[j] up to, not including, column_starts[j + 1].
struct SolveProjectArgs {
  ReadVec3s displacements;  // one per data point, metres
  ReadUints column_starts;
  ReadUints rows;
  ReadFloats weights;
  WriteDoubles projected;  // x y z of each control point
};

// solve_apply: p += (AᵀA)⁺ times that, one invocation per control point. The exact positions persist from
// frame to frame; the surface is evaluated from the rounded ones.
struct SolveApplyArgs {
  ReadDoubles projected;
  ReadDoubles gram_inverse;  // n x n, symmetric
  ReadWriteDoubles exact_points;
  WriteVec3s control_points;
  uint control_point_count;
};

AIRCLAY_IO_END

#endif
