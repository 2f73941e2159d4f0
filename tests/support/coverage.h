// SPDX-License-Identifier: MIT
// Coverage images: the fraction of each pixel, 0 to 1, that an object covers, row by row.
#pragma once

#include "engine/camera/rig.h"
#include "engine/mesh/mesh.h"

namespace airclay {

/// Area in pixels and centre of mass of a coverage image.
struct Shape {
  double area = 0;
  Vec2 center = Vec2::Zero();
};
Shape shapeOf(const std::vector<double>& coverages, int width);

/// The coverage of a mesh, from 6 x 6 samples per pixel of its triangles, projected by the CPU's lens.
std::vector<double> projectedCoverage(const Camera& camera, const TriangleMesh& mesh,
                                      const Pose& world_from_mesh);

}  // namespace airclay
