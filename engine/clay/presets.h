// SPDX-License-Identifier: MIT
// Initial clay shapes.
#pragma once

#include <string>

#include "engine/mesh/cage_file.h"
#include "engine/mesh/mesh.h"

namespace airclay {

/// The preset names, default first: tube, cube, ball, slab, vase.
const std::vector<std::string>& presetNames();

/// A preset's control cage, metres, about 0.2 m in size and centred at the origin. `tube` is the paper's
/// clay: an open tube of 7 x 4 control points, 28 -> 98 -> 364 data points. \throw Error listing the presets
/// if the name is unknown.
PolygonMesh presetCage(const std::string& name);

/// Loads a preset, or a file with readCage(); a preset's name takes precedence. `options` apply to files
/// only. \throw Error like presetCage() and readCage(), and (Fault::kUsage) if a preset is given a unit or an
/// up axis
CageReading loadCage(const std::string& preset_or_file, const CageReadOptions& options = {});

}  // namespace airclay
