// SPDX-License-Identifier: MIT
// Repairs a file's mesh into a control cage.
#pragma once

#include "engine/mesh/cage_file.h"
#include "engine/mesh/mesh_source.h"

namespace airclay {

/// Repairs `source` and reports what cannot be repaired. The cage has the file's units and axes; its format
/// and hints remain empty.
CageReading repairCage(MeshSource source);

}  // namespace airclay
