#version 460
// SPDX-License-Identifier: MIT
// Contact of one data point, or of a mirror image of it: its path in the hand frame since the last check, and where it has to move. See
// engine/sculpt/contact.h.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "shaders/sculpt/contact_io.h"
#include "shaders/core/invocation.glsl"
#include "shaders/core/quaternion.glsl"
#include "shaders/sculpt/symmetry.glsl"

layout(push_constant, scalar) uniform Push { ContactFindArgs args; };

#include "shaders/hand/hand_distance.glsl"

const float kNone = 1e30;     // no surface was found
const float kBuried = 2e30;   // no outside was found

// Not unrolled: each copy of distanceAt costs lavapipe's compiler a tenth of a second, here and in the loops below.
vec3 normalAt(vec3 point) {
  vec3 gradient = vec3(0);
  [[dont_unroll]] for (uint side = 0; side < 6; ++side) {
    const vec3 axis = vec3(side >> 1 == 0, side >> 1 == 1, side >> 1 == 2);
    const float sign_ = (side & 1u) == 0 ? 1 : -1;
    gradient += axis * sign_ * distanceAt(point + 0.5 * args.hand.cell_m * sign_ * axis);
  }
  const float size = length(gradient);
  return size > 0 ? gradient / size : vec3(0, 0, 1);
}

// The path of a data point while the hand moves from one pose to the next and the clay from one shape to the next, both at constant speed.
struct Path {
  vec4 rotation_from, rotation_to;
  vec3 center_from, center_to;
  vec3 point_from, point_to;
  float length_m;  // an upper bound
};

vec3 placeInHand(Path path, float t) {
  const vec4 rotation = normalize(mix(path.rotation_from, path.rotation_to, t));
  return rotate(conjugate(rotation), mix(path.point_from, path.point_to, t) - mix(path.center_from, path.center_to, t));
}

float boundOf(Path path) {
  // the interpolated quaternion turns fastest at the midpoint: 4 tan(angle / 4)
  const float cosine = min(dot(path.rotation_from, path.rotation_to), 1);
  const float turn = 4 * sqrt((1 - cosine) / (1 + cosine));
  const float arm = max(length(path.point_from - path.center_from), length(path.point_to - path.center_to));
  return length(path.point_to - path.point_from) + length(path.center_to - path.center_from) + turn * arm;
}

// The first t at which the path enters the hand, by conservative advancement, then bisection; kNone if it does not. `leaves`: it may start
// inside, and has to leave first.
float firstEntry(Path path, bool leaves) {
  const float min_step = max(kContactMinStep, path.length_m / kContactMaxSteps);
  float t = 0, outside = 0, inside = kNone;
  while (true) {
    const float distance_m = distanceAt(placeInHand(path, t));
    if (leaves) leaves = distance_m <= kContactReleaseDistance;
    else if (distance_m <= 0) inside = t;
    else outside = t;
    if (inside != kNone) {
      if ((inside - outside) * path.length_m <= kContactTolerance) return inside;
      t = 0.5 * (outside + inside);
    } else {
      if (t >= 1 || distance_m > (1 - t) * path.length_m) return kNone;
      t = min(1, t + max(leaves ? 0 : distance_m, min_step) / path.length_m);
      if (leaves) outside = t;
    }
  }
}

// The s of the first surface on the line place + s direction, from s = high down to low. kNone if there is none; kBuried if the line is
// inside far above `high`.
float firstSurface(vec3 place, vec3 direction, float high, float low) {
  float s = high, outside = kNone, inside = kNone;
  while (true) {
    const float distance_m = distanceAt(place + s * direction);
    if (distance_m > 0) outside = s;
    else if (outside != kNone) inside = s;
    if (outside == kNone) {
      s += max(-distance_m, kContactMinStep);
      if (s > high + kContactMaxClimb) return kBuried;
    } else if (inside == kNone) {
      if (s <= low) return kNone;
      s = max(low, s - max(distance_m, kContactMinStep));
    } else {
      if (outside - inside <= kContactTolerance) return outside;
      s = 0.5 * (outside + inside);
    }
  }
}

// Processes a point that was outside, or, if `leaves`, has just been released.
void sweep(Path path, bool leaves, inout GpuContactPoint point) {
  point.state = kPointOutside;
  point.depth = 0;
  const float t = firstEntry(path, leaves);
  if (t == kNone) return;
  const vec3 now = placeInHand(path, 1);
  vec3 back = placeInHand(path, t) - now;
  point.depth = length(back);
  if (point.depth <= kContactMinPath) back = placeInHand(path, 0) - now;  // entered at the very end
  point.state = kPointReached;
  point.depth_before = point.depth;
  point.direction = length(back) > 0 ? normalize(back) : vec3(0, 0, 1);
  point.pushed = 0;
  point.pushed_plain = 0;
  point.last_push = 0;
}

// Processes a reached point; returns true if the hand has released it.
bool follow(Path path, float distance_m, inout GpuContactPoint point) {
  const vec3 from = placeInHand(path, 0), to = placeInHand(path, 1);
  if (args.first != 0) point.direction = normalize(point.direction + kContactTurnToNormal * normalAt(from));
  const float high = max(0, dot(from - to, point.direction)) + max(0, point.depth) + kContactLift;
  point.depth_before = point.depth;
  point.depth = firstSurface(to, point.direction, high, -point.pushed);
  if (point.depth == kBuried) {
    point.state = kPointIgnored;
    point.depth = 0;
  } else if (point.depth == kNone) {
    point.depth = -point.pushed;
    return point.pushed == 0 && distance_m > kContactReleaseDistance;
  }
  return false;
}

void main() {
  const uint data_point = invocation();
  if (data_point >= args.data_point_count) return;
  const uint image = gl_WorkGroupID.z, index = image * args.data_point_count + data_point;
  const GpuContactFrame frame = args.frame.at[0];
  const uint state = args.points.at[index].state;
  GpuContactPoint point = GpuContactPoint(args.points.at[index].position, state, vec3(0), 0, 0, 0, 0, 0);
  if (state == kPointReached) point = args.points.at[index];
  const vec3 position = mirrorOf(args.mirrors, image) * args.data_points.at[data_point];
  Path path;
  path.rotation_to = frame.rotation_now;
  path.center_to = frame.position_now;
  path.rotation_from = args.first != 0 ? frame.rotation_before : frame.rotation_now;
  path.center_from = args.first != 0 ? frame.position_before : frame.position_now;
  path.point_from = point.position;
  path.point_to = position;
  path.length_m = boundOf(path);
  point.position = position;
  if (args.first != 0) {
    point.pushed = 0;
    point.pushed_plain = 0;
    point.last_push = 0;
  }
  const float distance_m = distanceAt(placeInHand(path, 1));
  if (frame.mode == kFrameStart) {
    point.state = distance_m <= 0 ? kPointIgnored : kPointOutside;
    point.depth = 0;
  } else if (state == kPointIgnored) {
    if (distance_m > kContactLeaveDistance) point.state = kPointOutside;
  } else {
    const bool reached = state == kPointReached;
    const bool released = reached && follow(path, distance_m, point);
    if (!reached || released) sweep(path, released, point);
  }
  if (frame.mode == kFrameSweep && state == kPointOutside && point.state == kPointOutside)
    args.points.at[index].position = position;  // for most points only the position changes
  else
    args.points.at[index] = point;
}
