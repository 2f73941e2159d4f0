// SPDX-License-Identifier: MIT
// The voxel model's surface as triangles, for other programs.
#pragma once

#include "engine/hull/carve.h"
#include "engine/mesh/mesh.h"

namespace airclay {

/// The hull's surface in the world, metres; empty if no voxel is occupied. It lies where the occupancy (0 or
/// 1), interpolated linearly between the voxels' centres, is one half; beyond the workspace it is 0. Closed,
/// anticlockwise from outside; the volume inside is that of the occupied voxels to a few percent where the
/// hull is thicker than three voxels.
TriangleMesh hullMesh(const VoxelGrid& grid, const Workspace& workspace);

}  // namespace airclay
