// SPDX-License-Identifier: MIT
// Makes a control cage of a mesh from a file.
#pragma once

#include "engine/mesh/cage_file.h"
#include "engine/mesh/mesh_source.h"

namespace airclay {

/// Repairs `source`, and looks for what cannot be repaired. The cage is in the units and axes of the file;
/// its format and hints are left empty.
CageReading repairCage(MeshSource source);

}  // namespace airclay
