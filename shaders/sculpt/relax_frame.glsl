// SPDX-License-Identifier: MIT
// The directions in which data points relax. The including shader's arguments have `data_points`, `normals`, `starts`, `neighbours` and
// `borders`.

// On a border, the direction across it and along the surface; else zero: there only the normal counts.
vec3 acrossBorder(uint index, vec3 normal) {
  if (args.borders.at[index] == 0) return vec3(0);
  const uint begin = args.starts.at[index];
  const vec3 along = args.data_points.at[args.neighbours.at[begin + 1]] - args.data_points.at[args.neighbours.at[begin]];
  const vec3 across = cross(along, normal);
  const float size = length(across);
  return size > 0 ? across / size : vec3(0);
}
