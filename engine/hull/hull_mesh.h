// SPDX-License-Identifier: MIT
// The voxel model's surface as a triangle mesh, for export.
#pragma once

#include "engine/hull/carve.h"
#include "engine/mesh/mesh.h"

namespace airclay {

/// The hull's surface, world, metres; empty if no voxel is occupied. It is the 0.5 level set of the occupancy
/// (0 or 1, trilinearly interpolated between voxel centres, 0 outside the workspace). Closed,
/// counterclockwise seen from outside. Its volume matches that of the occupied voxels to a few percent if the
/// hull is thicker than three voxels.
TriangleMesh hullMesh(const VoxelGrid& grid, const Workspace& workspace);

}  // namespace airclay
