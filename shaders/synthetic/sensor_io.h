// SPDX-License-Identifier: MIT
// The synthetic cameras' arguments. Lengths are in metres in the workspace's frame (camera_io.h).
#ifndef AIRCLAY_SENSOR_IO_H
#define AIRCLAY_SENSOR_IO_H

#include "shaders/camera/camera_io.h"

AIRCLAY_IO_BEGIN

const uint kSensorWorkgroup = 64;
const uint kRayStep =
    16;  // pixels between the rays that the backdrop is given; the lens is smooth between them
// The noise table: three numbers, normally distributed, an entry; each of 21 bits that reach kNoiseReach to
// each side of 0.
const uint kNoiseBits = 13;  // of its index: numbers up to 3.8
const uint kNoiseSteps = (1 << 21) - 1;
const float kNoiseReach = 4;
const uint kShadowCells = 64;    // along each side of the floor's shadow map
const float kShadowHalf = 1.7f;  // the map reaches this many workspace edges to each side of the middle

// The backdrop holds a word a pixel: what it shows with nothing before it (sRGB in 11, 11 and 10 bits, red
// lowest: finer than the noise); and behind all of these another word a pixel: where that place lies in the
// shadow map (16 bits each way, whole map).

// sensor_backdrop.comp: a studio's sweep (floor, rounded into a round wall), lit from above.
struct BackdropArgs {
  ReadVec3s rays;  // unit, camera coordinates, every kRayStep pixels; 0 where no light arrives
  WriteUints backdrop;
  mat3 workspace_from_camera;
  vec3 eye;
  uint width;
  uint height;
  uint pixels_before;
  uint all_pixels;   // of all cameras
  uint first_pixel;  // of the band that is drawn
  float edge_m;      // the workspace's
  float floor_z;
  float wall_radius;
  vec2 key_slope;  // metres sideways a metre up, towards the light
};

// sensor.vert, sensor.frag
struct SensorMeshArgs {
  ReadCameras cameras;
  ReadVec3s positions;  // hand frame
  ReadVec4s normals;    // unit, hand frame; w: how open the place is to light from all around, 0 to 1
  mat3 camera_from_hand;
  vec3 hand_in_camera;  // camera_from_hand's translation
  vec3 key_in_hand;     // unit, towards the light
  vec3 up_in_hand;      // unit
  uint camera;
};

// sensor_shadow.comp: the hand's soft shadow on the floor as a factor of sRGB values, an invocation a cell.
struct ShadowArgs {
  ReadVec3s spots;  // places all over the skin, hand frame
  WriteFloats shadow;
  mat3 workspace_from_hand;
  vec3 hand_in_workspace;
  uint spot_count;
  float edge_m;
  float floor_z;
  vec2 key_slope;
  float spot_weight;  // depth of one spot's shadow
};

// sensor_compose.comp: a camera's hand before its backdrop, noise, bytes. Four pixels, three words, an
// invocation.
struct ComposeArgs {
  ReadCameras cameras;
  ReadUints hand;  // RGBA, premultiplied by the coverage in linear light, then sRGB; alpha is the coverage
  ReadUints backdrop;
  ReadFloats shadow;
  ReadUlongs noise;   // the table
  WriteUints images;  // GpuRig's layout
  uint camera;
  uint all_pixels;  // of all cameras
  uint seed;
  uint frame;
  float noise_sigma;  // of 255
  float brightness;   // 1 for none brighter or darker
};

AIRCLAY_IO_END

#endif
