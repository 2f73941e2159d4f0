// SPDX-License-Identifier: MIT
// A calibrated camera as the kernels see it, and the layout of its mask.
#ifndef AIRCLAY_CAMERA_IO_H
#define AIRCLAY_CAMERA_IO_H

#include "shaders/core/io.h"

AIRCLAY_IO_BEGIN

// Lens kinds. A perspective lens whose coefficients are all zero is a pinhole: the polynomials are skipped.
const uint kLensPinhole = 0;
const uint kLensPerspective = 1;
const uint kLensRational = 2;  // perspective with k4, k5, k6
const uint kLensFisheye = 3;

// Masks hold one bit a pixel, 32 pixels a word, the lowest bit leftmost; a row is a whole number of word
// pairs, and bits behind the image's right edge are 0. load_camera.glsl reads it two words at a time: on
// lavapipe a load costs the same for one word and for two.
struct GpuCamera {
  mat3 rotation;  // camera_from_workspace; the workspace's frame is the world's, moved to the cube's centre
  vec3 translation;  // metres
  vec2 focal;        // pixels
  vec2 center;       // pixels, centres at whole numbers
  float distortion[8];
  float limit;      // end of the lens model's monotonic range: r, or theta for the fisheye (rig.h)
  float visible;    // no point of the image lies farther out than this; same quantity
  float steepness;  // largest change of a distorted coordinate a unit of the same undistorted one, up to 1.1
                    // visible;
  float cross_steepness;  // of the other one. Fisheye: of the image's position a radian, and 0
  uint width;
  uint height;
  uint lens;
  uint tile_entries;   // entries a row of tiles (carve_io.h)
  uint first_entry;    // before this camera's tiles
  uint row_words;      // words a row of the mask
  uint mask_words;     // words before this camera's mask
  uint image_words;    // words before this camera's image
  uint pixels_before;  // pixels of the cameras before it
  uint pad;
};

READ_POINTER(ReadCameras, GpuCamera)

AIRCLAY_IO_END

#endif
