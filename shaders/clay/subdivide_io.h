// SPDX-License-Identifier: MIT
// The clay's surface in device memory: eq. (5), d = A p, and the normals of the subdivided polyhedron.
#ifndef AIRCLAY_SUBDIVIDE_IO_H
#define AIRCLAY_SUBDIVIDE_IO_H

#include "shaders/core/io.h"

AIRCLAY_IO_BEGIN

// Workgroup size of both kernels.
const uint kSubdivideWorkgroup = 64;

// subdivide: one invocation per data point. A is stored by rows: row i's weights and control points are at
// row_starts[i] up to, not including, row_starts[i + 1].
struct SubdivideArgs {
  ReadVec3s control_points;
  ReadUints row_starts;
  ReadUints columns;
  ReadFloats weights;
  WriteVec3s data_points;
  uint data_point_count;
};

// normals: one invocation per data point. The quads adjacent to data point i are `quads_at` from
// quad_starts[i] up to, not including, quad_starts[i + 1].
struct NormalsArgs {
  ReadVec3s data_points;
  ReadUints quad_starts;
  ReadUints quads_at;
  ReadUints quads;  // four data points each
  WriteVec3s normals;
  uint data_point_count;
};

AIRCLAY_IO_END

#endif
