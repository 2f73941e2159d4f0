// SPDX-License-Identifier: MIT
// A line across the projected outline. The including shader's arguments have the members of OutlineCoarseArgs up to `forearms`.

#include "shaders/camera/image_layout.glsl"
#include "shaders/camera/lens.glsl"
#include "shaders/core/quaternion.glsl"
#include "shaders/hand/outline_pose.glsl"

struct Line {
  vec2 point, normal;      // the middle of the projected edge, and its unit normal, outwards
  uint inside, outside;    // how far it may be searched, pixels
  float length_;           // of the edge; 0: not part of the outline
  GpuOutlineEdge edge;
};

bool isCovered(ImageLayout image, vec2 point) {
  const ivec2 at = ivec2(floor(point + 0.5));
  if (any(lessThan(at, ivec2(0))) || at.x >= int(image.width) || at.y >= int(image.height)) return false;
  return (args.masks.at[image.mask_words + uint(at.y) * image.row_words + uint(at.x >> 5)] >> (at.x & 31) & 1u) != 0;
}

bool isWithin(ImageLayout image, vec2 point, float margin) {
  return all(greaterThanEqual(point, vec2(margin))) && point.x < float(image.width) - 1 - margin && point.y < float(image.height) - 1 - margin;
}

bool isForearm(vec4 from, vec2 to, vec2 point) {
  const vec2 along = to - from.xy, offset = point - from.xy;
  return length(offset - clamp(dot(offset, along) / max(dot(along, along), 1e-9), 0, 1) * along) < from.z;
}

// The line of an entry of the camera's list, searched up to `reach` pixels either way: to the middle of the gap to the next part of the
// hand, to the middle of the part that it bounds, and not into the forearm.
Line lineOf(ImageLayout image, uint camera, uint entry, uint reach) {
  Line line;
  line.length_ = 0;
  line.edge = args.edges.at[args.lists.at[camera * kOutlineList + 1 + entry]];
  const vec2 from = args.pixels.at[camera * args.vertex_count + line.edge.from], to = args.pixels.at[camera * args.vertex_count + line.edge.to];
  const float edge_length = length(to - from);
  line.point = 0.5 * (from + to);
  line.normal = vec2(from.y - to.y, to.x - from.x) / edge_length;
  const bool ahead = isCovered(image, line.point + kBesideEdge * line.normal);
  if (ahead == isCovered(image, line.point - kBesideEdge * line.normal)) return line;
  if (ahead) line.normal = -line.normal;
  if (isCovered(image, line.point + kClearOfEdge * line.normal) || !isWithin(image, line.point, 3)) return line;
  const vec4 arm_from = args.forearms.at[2 * camera];
  const vec2 arm_to = args.forearms.at[2 * camera + 1].xy;
  if (isForearm(arm_from, arm_to, line.point) || isForearm(arm_from, arm_to, line.point + 4 * line.normal)) return line;

  line.outside = reach;
  for (uint k = 3; k <= reach; ++k)
    if (isCovered(image, line.point + float(k) * line.normal)) {
      line.outside = k / 2;
      break;
    }
  line.inside = reach;
  for (uint k = 2; k <= reach; ++k)
    if (!isCovered(image, line.point - float(k) * line.normal)) {
      line.inside = max(1, k / 2);
      break;
    }
  while (line.outside > 1 && !isWithin(image, line.point + float(line.outside) * line.normal, 2)) --line.outside;
  while (line.inside > 1 && !isWithin(image, line.point - float(line.inside) * line.normal, 2)) --line.inside;
  for (uint k = 1; k <= line.outside; ++k)
    if (isForearm(arm_from, arm_to, line.point + float(k) * line.normal)) {
      line.outside = k;
      break;
    }
  line.length_ = edge_length;
  return line;
}

const float kDifference = 2e-3;  // metres: for derivatives of the projection

// How the projected edge moves along the line's normal with the pose.
float[7] rowOf(GpuCamera camera, Line line, GpuOutlinePose pose) {
  const vec3 middle = 0.5 * (args.vertices.at[line.edge.from] + args.vertices.at[line.edge.to]);
  const vec3 arm = rotate(pose.rotation, pose.scale * middle);
  const vec3 point = camera.rotation * (pose.position + arm) + camera.translation;
  vec3 gradient;
  for (uint k = 0; k < 3; ++k) {
    vec3 step_ = vec3(0);
    step_[k] = kDifference;
    gradient[k] = dot(line.normal, projectThroughLens(camera, point + step_).pixel - projectThroughLens(camera, point - step_).pixel) / (2 * kDifference);
  }
  gradient = transpose(camera.rotation) * gradient;
  const vec3 turn = cross(arm, gradient);
  return float[7](gradient.x, gradient.y, gradient.z, turn.x, turn.y, turn.z, dot(gradient, arm));
}

// How far the edge moves along the line while the image is exposed, pixels.
float blurOf(float[7] row) {
  const vec3 shift = vec3(row[0], row[1], row[2]), turn = vec3(row[3], row[4], row[5]);
  return min(kMostBlur, kExposure * abs(dot(shift, args.frame.at[0].velocity) + dot(turn, args.frame.at[0].spin)));
}

const GpuOutlineLine kNoLine = GpuOutlineLine(float[7](0, 0, 0, 0, 0, 0, 0), 0, 0, 0, 0, 0);
