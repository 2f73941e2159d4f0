// SPDX-License-Identifier: MIT
// The synthetic cameras' arguments. Lengths are in metres in the workspace frame (camera_io.h).
#ifndef AIRCLAY_SENSOR_IO_H
#define AIRCLAY_SENSOR_IO_H

#include "shaders/camera/camera_io.h"

AIRCLAY_IO_BEGIN

const uint kSensorWorkgroup = 64;
const uint kRayStep = 16;  // pixels between the rays given to the backdrop; the lens is smooth between them
// The noise table: three normally distributed numbers per entry, each of 21 bits that span -kNoiseReach to
// kNoiseReach.
const uint kNoiseBits = 13;  // bits of its index: numbers up to 3.8
const uint kNoiseSteps = (1 << 21) - 1;
const float kNoiseReach = 4;
const uint kShadowCells = 64;    // along each side of the floor's shadow map
const float kShadowHalf = 1.7f;  // half the map's edge, in workspace edges

// The backdrop has one word per pixel for its colour without a hand (sRGB in 11, 11 and 10 bits, red lowest:
// finer than the noise), followed by one word per pixel for the pixel's position in the shadow map (16 bits
// per axis, over the whole map).

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
  float edge_m;      // of the workspace
  float floor_z;
  float wall_radius;
  vec2 key_slope;  // metres sideways per metre up, towards the light
};

// sensor.vert, sensor.frag
struct SensorMeshArgs {
  ReadCameras cameras;
  ReadVec3s positions;  // hand frame
  ReadVec4s normals;    // unit, hand frame; w: openness to ambient light, 0 to 1
  mat3 camera_from_hand;
  vec3 hand_in_camera;  // translation of camera_from_hand
  vec3 key_in_hand;     // unit, towards the light
  vec3 up_in_hand;      // unit
  uint camera;
};

// sensor_shadow.comp: the hand's soft shadow on the floor as a factor of sRGB values, one invocation per
// cell.
struct ShadowArgs {
  ReadVec3s spots;  // points distributed over the skin, hand frame
  WriteFloats shadow;
  mat3 workspace_from_hand;
  vec3 hand_in_workspace;
  uint spot_count;
  float edge_m;
  float floor_z;
  vec2 key_slope;
  float spot_weight;  // depth of one spot's shadow
};

// sensor_compose.comp: a camera's hand in front of its backdrop, noise, bytes. Each invocation writes four
// pixels, three words.
struct ComposeArgs {
  ReadCameras cameras;
  ReadUints hand;  // RGBA, premultiplied by the coverage in linear light, then sRGB; alpha is the coverage
  ReadUints backdrop;
  ReadFloats shadow;
  ReadUlongs noise;   // the noise table
  WriteUints images;  // GpuRig's layout
  uint camera;
  uint all_pixels;  // of all cameras
  uint seed;
  uint frame;
  float noise_sigma;  // of 255
  float brightness;   // 1: unchanged
};

AIRCLAY_IO_END

#endif
