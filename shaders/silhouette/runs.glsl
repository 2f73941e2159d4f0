// SPDX-License-Identifier: MIT
// Union-find over runs of pixels: labels only ever decrease, so many invocations can join parts at once (Playne and Hawick 2018, "A new
// algorithm for parallel connected-component labelling on GPUs", applied to runs).

#include "shaders/camera/image_layout.glsl"
#include "shaders/silhouette/silhouette_io.h"

layout(local_size_x_id = 0) in;
layout(push_constant, scalar) uniform Push { RunArgs args; };

// The first entry of a row's runs.
uint runsOf(uint camera, uint row) { return (camera * args.max_rows + row) * kMaxRuns; }

uint rootOf(uint label) {
  uint next = args.labels.at[label];
  while (next != label) {
    label = next;
    next = args.labels.at[label];
  }
  return label;
}
