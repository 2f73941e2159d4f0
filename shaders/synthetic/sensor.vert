#version 460
// SPDX-License-Identifier: MIT
// Projects the hand's vertices through a camera's own lens. Lens distortion bends edges: the result is exact at the corners, and the
// triangles are small.
#extension GL_GOOGLE_include_directive : require
#include "shaders/synthetic/sensor_io.h"
#include "shaders/camera/camera_io.h"
const uint kLenses = 15;  // every kind
#include "shaders/camera/lens.glsl"
#include "shaders/synthetic/noise.glsl"

layout(push_constant, scalar) uniform Push { SensorMeshArgs args; };
layout(location = 0) out vec3 place_in_hand;
layout(location = 1) out vec4 normal_in_hand;  // w: openness
layout(location = 2) out float blotch;

out gl_PerVertex {
  vec4 gl_Position;
  float gl_ClipDistance[1];
};

const float kNear = 0.01;  // metres: nearer surfaces are clipped

void main() {
  const GpuCamera camera = args.cameras.at[args.camera];
  place_in_hand = args.positions.at[gl_VertexIndex];
  normal_in_hand = args.normals.at[gl_VertexIndex];
  blotch = smoothstep(0.3, 0.7, fractalNoise(70 * place_in_hand, 3));  // wider than a triangle
  const vec3 in_camera = args.camera_from_hand * place_in_hand + args.hand_in_camera;
  const Projection projection = projectThroughLens(camera, in_camera);
  const vec2 clip = 2 * (projection.pixel + 0.5) / vec2(camera.width, camera.height) - 1;  // pixel centres at whole numbers
  gl_Position = projection.valid ? vec4(clip * in_camera.z, in_camera.z * (1 - kNear / length(in_camera)), in_camera.z)
                                 : vec4(2, 2, 2, 1);
  // clips the whole triangle if the lens does not see one of its corners
  gl_ClipDistance[0] = projection.valid ? 1 : -1e9;
}
