#version 460
// SPDX-License-Identifier: MIT
// Makes the control points of each orbit exact images of one another: the average of all, mirrored back. In place, since orbits are
// disjoint.
#extension GL_GOOGLE_include_directive : require
#include "shaders/sculpt/symmetry_io.h"
#include "shaders/core/invocation.glsl"
#include "shaders/sculpt/symmetry.glsl"

layout(push_constant, scalar) uniform Push { SymmetryAverageArgs args; };

void main() {
  const uint orbit = invocation();
  if (orbit >= args.orbit_count) return;
  const uint images = imageCount(args.mirrors);
  dvec3 sum = dvec3(0);
  for (uint image = 0; image < images; ++image) {
    const uint at = 3 * args.orbits.at[orbit * images + image];
    sum += dvec3(mirrorOf(args.mirrors, image)) *
           dvec3(args.exact_points.at[at], args.exact_points.at[at + 1], args.exact_points.at[at + 2]);
  }
  const dvec3 average = sum / images;
  for (uint image = 0; image < images; ++image) {
    const uint point = args.orbits.at[orbit * images + image];
    const dvec3 position = dvec3(mirrorOf(args.mirrors, image)) * average;
    for (uint axis = 0; axis < 3; ++axis) args.exact_points.at[3 * point + axis] = position[axis];
    args.control_points.at[point] = vec3(position);
  }
}
