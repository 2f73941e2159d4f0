// SPDX-License-Identifier: MIT
// A block of voxels projected into a camera's image. The including shader includes lens.glsl.

const uint kUnseen = 0;      // the camera sees none of its voxels
const uint kPartlySeen = 1;  // it may see some
const uint kWholeSeen = 2;   // it sees every voxel

struct Footprint {
  uint seen;
  vec2 low, high;  // pixel bounds of the voxels' centres, if the whole block is seen
};

// `center` is in camera coordinates; the block's voxel centres are within `half_size` of it along each workspace axis (metres).
Footprint footprintOf(GpuCamera camera, vec3 center, float half_size) {
  Footprint footprint = Footprint(kPartlySeen, vec2(0), vec2(0));
  const mat3 axes = camera.rotation;  // of the workspace, in camera coordinates
  const float depth = half_size * (abs(axes[0].z) + abs(axes[1].z) + abs(axes[2].z));
  if (center.z <= -depth) footprint.seen = kUnseen;
  if (center.z <= depth) return footprint;

  // Bound on the distance between the centre's direction and the others, as a change of the undistorted position, and of the pixel.
  float position, deviation;
  vec2 reach;
  if (rigHas(kLensFisheye) && camera.lens == kLensFisheye) {
    position = atan(length(center.xy), center.z);
    deviation = asin(min(half_size * 1.7320508 / length(center), 1.0));
    reach = camera.focal * (camera.max_stretch * deviation);
  } else {
    // (x + δx) / (z + δz) - x / z = (δx - x/z δz) / (z + δz), with δ = Σ e_k axes[k] and |e_k| <= half_size
    const vec2 x = center.xy / center.z;
    const vec2 across = (abs(axes[0].xy - x * axes[0].z) + abs(axes[1].xy - x * axes[1].z) + abs(axes[2].xy - x * axes[2].z)) *
                        (half_size / (center.z - depth));
    position = length(x);
    deviation = length(across);
    reach = camera.focal * (camera.max_stretch * across + camera.max_cross_stretch * across.yx);
  }
  if (position - deviation > camera.visible) footprint.seen = kUnseen;
  if (position + deviation > min(camera.limit, 1.1 * camera.visible)) return footprint;

  const vec2 pixel = projectThroughLens(camera, center).pixel;
  reach += 0.01;  // margin for float rounding
  footprint.low = pixel - reach;
  footprint.high = pixel + reach;
  const vec2 size = vec2(camera.width, camera.height);
  if (any(lessThan(footprint.high, vec2(-0.5))) || any(greaterThanEqual(footprint.low, size - 0.5))) footprint.seen = kUnseen;
  else if (all(greaterThanEqual(footprint.low, vec2(-0.5))) && all(lessThan(footprint.high, size - 0.5))) footprint.seen = kWholeSeen;
  return footprint;
}

// The pixel that contains a position inside the image.
uvec2 pixelAt(vec2 position) { return uvec2(position + 0.5); }
