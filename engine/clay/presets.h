// SPDX-License-Identifier: MIT
// The clay one starts from.
#pragma once

#include <string>

#include "engine/mesh/mesh.h"

namespace airclay {

/// Names of the presets, the default first: tube, cube, ball, slab, vase.
const std::vector<std::string>& presetNames();

/// A preset's control cage, centred in the workspace and about 0.2 m large. `tube` is the paper's clay: an
/// open tube of 7 x 4 control points, 28 -> 98 -> 364 data points. \throw Error naming the presets when there
/// is none of this name.
PolygonMesh presetCage(const std::string& name);

/// A preset's name or an OBJ file's path, the preset first.
PolygonMesh loadCage(const std::string& preset_or_file);

}  // namespace airclay
