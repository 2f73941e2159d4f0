// SPDX-License-Identifier: MIT
// Loads a camera for a whole subgroup. The including shader has the specialization constant kLanes: how many neighbours load it together,
// at most the subgroup size.
#extension GL_KHR_shader_subgroup_ballot : require

#include "shaders/camera/camera_io.h"

READ_POINTER(ReadCameraWords, uint64_t)

const uint kCameraPairs = 19;

// Loads the same camera for all invocations of a fully active subgroup: each loads a few pairs of words and broadcasts them. A load costs
// as much as thirty operations on lavapipe.
GpuCamera loadCamera(ReadCameras cameras, uint index) {
  ReadCameraWords words = ReadCameraWords(uint64_t(cameras) + 8ul * kCameraPairs * index);
  uvec2 loaded[kCameraPairs];
  for (uint i = 0; i < (kCameraPairs + kLanes - 1) / kLanes; ++i)
    loaded[i] = unpackUint2x32(words.at[min(i * kLanes + gl_SubgroupInvocationID % kLanes, kCameraPairs - 1)]);
#define PAIR(k) subgroupBroadcast(loaded[(k) / kLanes], (k) % kLanes)
#define REAL_PAIR(k) uintBitsToFloat(PAIR(k))
  GpuCamera camera;
  const vec2 r0 = REAL_PAIR(0), r1 = REAL_PAIR(1), r2 = REAL_PAIR(2), r3 = REAL_PAIR(3), r4 = REAL_PAIR(4), r5 = REAL_PAIR(5);
  camera.rotation = mat3(r0.x, r0.y, r1.x, r1.y, r2.x, r2.y, r3.x, r3.y, r4.x);
  camera.translation = vec3(r4.y, r5);
  camera.focal = REAL_PAIR(6);
  camera.center = REAL_PAIR(7);
  const vec2 d0 = REAL_PAIR(8), d1 = REAL_PAIR(9), d2 = REAL_PAIR(10), d3 = REAL_PAIR(11);
  camera.distortion = float[8](d0.x, d0.y, d1.x, d1.y, d2.x, d2.y, d3.x, d3.y);
  const vec2 range = REAL_PAIR(12), steep = REAL_PAIR(13);
  camera.limit = range.x;
  camera.visible = range.y;
  camera.max_stretch = steep.x;
  camera.max_cross_stretch = steep.y;
  const uvec2 size = PAIR(14), kind = PAIR(15), rows = PAIR(16), masks = PAIR(17);
  camera.width = size.x;
  camera.height = size.y;
  camera.lens = kind.x;
  camera.tile_entries = kind.y;
  camera.first_entry = rows.x;
  camera.row_words = rows.y;
  camera.mask_words = masks.x;
  camera.image_words = masks.y;
  return camera;
#undef REAL_PAIR
#undef PAIR
}
