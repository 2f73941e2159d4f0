// SPDX-License-Identifier: MIT
// The hand's pose at a camera's own time.

GpuOutlinePose poseAt(ReadOutlinePoses poses, ReadOutlineFrames frames, uint camera) {
  GpuOutlinePose pose = poses.at[0];
  const float seconds = frames.at[0].seconds[camera];
  if (seconds == 0) return pose;
  const vec3 turn = seconds * frames.at[0].spin;
  const float angle = length(turn);
  const vec3 axis = angle > 1e-9 ? turn / angle : vec3(1, 0, 0);
  pose.rotation = multiply(vec4(axis * sin(0.5 * angle), cos(0.5 * angle)), pose.rotation);
  pose.position += seconds * frames.at[0].velocity;
  return pose;
}

// A point of the hand, from its centre of gravity in the hand's axes, in the workspace.
vec3 pointAt(GpuOutlinePose pose, vec3 point) { return pose.position + rotate(pose.rotation, pose.scale * point); }
