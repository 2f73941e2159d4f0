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

// Masks hold one bit per pixel, 32 pixels per word, the lowest bit leftmost. A row is a whole number of word
// pairs; bits past the image's right edge are 0. load_camera.glsl reads this struct two words at a time: on
// lavapipe, loading two words costs the same as loading one.
struct GpuCamera {
  mat3 rotation;  // camera_from_workspace; the workspace frame is the world frame moved to the cube's centre
  vec3 translation;  // metres
  vec2 focal;        // pixels
  vec2 center;       // pixels, centres at whole numbers
  float distortion[8];
  float limit;        // end of the lens model's monotonic range: r, or theta for the fisheye (rig.h)
  float visible;      // no image point is farther out than this; same quantity
  float max_stretch;  // largest change of a distorted coordinate per unit of the same undistorted one, up
                      // to 1.1 visible
  float max_cross_stretch;  // per unit of the other one. Fisheye: max_stretch is image position per radian;
                            // this is 0
  uint width;
  uint height;
  uint lens;
  uint tile_entries;   // entries per row of tiles (carve_io.h)
  uint first_entry;    // entries before this camera's tiles
  uint row_words;      // words per row of the mask
  uint mask_words;     // words before this camera's mask
  uint image_words;    // words before this camera's image
  uint pixels_before;  // pixels of all cameras before this one
  uint pad;
};

READ_POINTER(ReadCameras, GpuCamera)

AIRCLAY_IO_END

#endif
