#version 460
// SPDX-License-Identifier: MIT
// The hand's triangles through a camera's own lens. The lens bends what is straight: that is exact at the corners, and the triangles
// are small.
#extension GL_GOOGLE_include_directive : require
#include "shaders/sensor_io.h"
#include "shaders/camera_io.h"
const uint kLenses = 15;  // every kind
#include "shaders/lens.glsl"

layout(push_constant, scalar) uniform Push { SensorMeshArgs args; };
layout(location = 0) out vec3 place_in_hand;
layout(location = 1) out vec4 normal_in_hand;  // w: openness

const float kNear = 0.01;  // metres: nearer surfaces are clipped

void main() {
  const GpuCamera camera = args.cameras.at[args.camera];
  const uint corner = gl_VertexIndex % 3, triangle = gl_VertexIndex - corner;
  // a triangle of which the lens does not see a corner is not drawn: its three invocations come to the same result
  bool valid = true;
  vec3 in_camera;
  vec2 pixel;
  for (uint i = 0; i < 3; ++i) {
    const vec3 p = args.camera_from_hand * args.positions.at[args.indices.at[triangle + i]] + args.hand_in_camera;
    const Projection projection = projectThroughLens(camera, p);
    valid = valid && projection.valid;
    if (i == corner) {
      in_camera = p;
      pixel = projection.pixel;
    }
  }
  const uint vertex = args.indices.at[gl_VertexIndex];
  place_in_hand = args.positions.at[vertex];
  normal_in_hand = args.normals.at[vertex];
  const vec2 clip = 2 * (pixel + 0.5) / vec2(camera.width, camera.height) - 1;  // pixel centres at whole numbers
  gl_Position = valid ? vec4(clip * in_camera.z, in_camera.z * (1 - kNear / length(in_camera)), in_camera.z)
                      : vec4(2, 2, 2, 1);
}
