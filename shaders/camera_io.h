// SPDX-License-Identifier: MIT
// A calibrated camera as the kernels see it, and the layout of its mask.
#ifndef AIRCLAY_CAMERA_IO_H
#define AIRCLAY_CAMERA_IO_H

#include "shaders/io.h"

AIRCLAY_IO_BEGIN

// Lens kinds. A perspective lens whose coefficients are all zero is a pinhole: the polynomials are skipped.
const uint kLensPinhole = 0;
const uint kLensPerspective = 1;
const uint kLensFisheye = 2;

// Masks hold one bit a pixel, 32 pixels a word, the lowest bit leftmost; rows start at whole words, and bits behind the picture's
// right edge are 0.
struct GpuCamera {
  mat3 rotation;     // camera_from_workspace; the workspace's frame is the world's, moved to the cube's centre
  vec3 translation;  // metres
  vec2 focal;        // pixels
  vec2 center;       // pixels, centres at whole numbers
  float distortion[8];
  uint lens;
  uint width;
  uint height;
  float limit;        // end of the lens model's monotonic range: r, or theta for the fisheye (rig.h)
  float visible;      // no point of the picture lies farther out than this; same quantity
  float steepness;    // largest change of the distorted position a unit of the undistorted one, up to `visible` + 10 %
  uint mask_words;    // words before this camera's mask
  uint row_words;     // words a row
  uint tile;          // pixels along a tile's edge, 4 or more: tiles carry the summed-area tables
  uint tiles_x;
  uint tiles_y;
  uint table_words;   // uints before this camera's tables
  uint picture_words;  // words before this camera's picture
  uint pixels_before;  // pixels of the cameras before it
};

READ_POINTER(ReadCameras, GpuCamera)

AIRCLAY_IO_END

#endif
