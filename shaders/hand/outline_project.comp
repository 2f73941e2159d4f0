#version 460
// SPDX-License-Identifier: MIT
// Projects the skin and the forearm's axis into a camera, at the camera's own time.
#extension GL_GOOGLE_include_directive : require
layout(constant_id = 1) const uint kLenses = 15;
#include "shaders/hand/outline_io.h"
#include "shaders/camera/lens.glsl"
#include "shaders/core/quaternion.glsl"
#include "shaders/hand/outline_pose.glsl"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { OutlineProjectArgs args; };

void main() {
  const uint vertex = gl_GlobalInvocationID.x, index = gl_WorkGroupID.y;
  if (vertex > args.vertex_count) return;
  const GpuCamera camera = args.cameras.at[index];
  const GpuOutlinePose pose = poseAt(args.pose, args.frame, index);
  if (vertex < args.vertex_count) {
    const Projection projection = projectThroughLens(camera, camera.rotation * pointAt(pose, args.vertices.at[vertex]) + camera.translation);
    args.pixels.at[index * args.vertex_count + vertex] = projection.valid ? projection.pixel : vec2(kNotProjected);
    return;
  }
  const vec3 from = camera.rotation * pointAt(pose, args.frame.at[0].arm_from) + camera.translation;
  vec3 to = camera.rotation * pointAt(pose, args.frame.at[0].arm_to) + camera.translation;
  if (to.z < kNearest) to = mix(from, to, max(0, (kNearest - from.z) / (to.z - from.z)));
  const Projection start = projectThroughLens(camera, from), end = projectThroughLens(camera, to);
  const vec2 start_pixel = start.valid ? start.pixel : vec2(kNotProjected);
  const float radius = camera.focal.x * pose.scale * args.frame.at[0].arm_radius / max(kNearest, from.z);
  args.forearms.at[2 * index] = vec4(start_pixel, radius, 0);
  args.forearms.at[2 * index + 1] = vec4(end.valid ? end.pixel : start_pixel, 0, 0);
}
