// SPDX-License-Identifier: MIT
// Draws figures 1 to 6 of the paper from the demo's hand, cameras and clay.
#pragma once

#include <filesystem>
#include <functional>

#include "engine/gpu/gpu.h"

namespace airclay {

/// How many times drawFigures() reports a finished part.
int figureSteps();

/// Writes figure1.png to figure6.png into a folder that exists. `voxels` along the workspace's edge.
void drawFigures(Gpu& gpu, const std::filesystem::path& folder, int voxels,
                 const std::function<void()>& step_done);

}  // namespace airclay
