#version 460
// SPDX-License-Identifier: MIT
// Projects the skin and the forearm's axis into a camera, at the camera's own time.
#extension GL_GOOGLE_include_directive : require
layout(constant_id = 1) const uint kLenses = 15;
layout(constant_id = 2) const uint kLanes = 1;
#include "shaders/hand/outline_io.h"
#include "shaders/camera/lens.glsl"
#include "shaders/camera/load_camera.glsl"
#include "shaders/core/quaternion.glsl"
#include "shaders/hand/outline_pose.glsl"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { OutlineProjectArgs args; };

void main() {
  const uint index = gl_WorkGroupID.y;
  const GpuCamera camera = loadCamera(args.cameras, index);
  const GpuOutlinePose pose = poseAt(args.pose, args.frame, index);
  const mat3 turn = camera.rotation * mat3(rotate(pose.rotation, vec3(1, 0, 0)), rotate(pose.rotation, vec3(0, 1, 0)), rotate(pose.rotation, vec3(0, 0, 1))) * pose.scale;
  const vec3 center = camera.rotation * pose.position + camera.translation;
  for (uint vertex = gl_GlobalInvocationID.x; vertex < args.vertex_count; vertex += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
    const Projection projection = projectThroughLens(camera, center + turn * args.vertices.at[vertex]);
    args.pixels.at[index * args.vertex_count + vertex] = projection.valid ? projection.pixel : vec2(kNotProjected);
  }
  if (gl_GlobalInvocationID.x != 0) return;
  const vec3 from = center + turn * args.frame.at[0].arm_from;
  vec3 to = center + turn * args.frame.at[0].arm_to;
  if (to.z < kNearest) to = mix(from, to, max(0, (kNearest - from.z) / (to.z - from.z)));
  const Projection start = projectThroughLens(camera, from), end = projectThroughLens(camera, to);
  const vec2 start_pixel = start.valid ? start.pixel : vec2(kNotProjected);
  const float radius = camera.focal.x * pose.scale * args.frame.at[0].arm_radius / max(kNearest, from.z);
  args.forearms.at[2 * index] = vec4(start_pixel, radius, 0);
  args.forearms.at[2 * index + 1] = vec4(end.valid ? end.pixel : start_pixel, 0, 0);
}
