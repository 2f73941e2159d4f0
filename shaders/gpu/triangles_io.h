// SPDX-License-Identifier: MIT
// Plain coloured triangles in clip space, for the tests of the graphics layer.
#ifndef AIRCLAY_TRIANGLES_IO_H
#define AIRCLAY_TRIANGLES_IO_H

#include "shaders/core/io.h"

AIRCLAY_IO_BEGIN

struct TrianglesArgs {
  ReadVec3s corners;  // three per triangle; x, y from -1 to 1, y down; z is the depth
  vec4 color;         // linear light
};

AIRCLAY_IO_END

#endif
