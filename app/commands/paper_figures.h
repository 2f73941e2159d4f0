// SPDX-License-Identifier: MIT
// The paper's figures 1 to 6, drawn from our own data: the demo's hand, cameras and clay.
#pragma once

#include <filesystem>
#include <functional>

#include "engine/gpu/gpu.h"

namespace airclay {

/// How many times drawFigures() says that a part of the work is done.
int figureSteps();

/// Writes figure1.png to figure6.png into a folder that exists. `voxels` along the workspace's edge.
void drawFigures(Gpu& gpu, const std::filesystem::path& folder, int voxels,
                 const std::function<void()>& step_done);

}  // namespace airclay
