// SPDX-License-Identifier: MIT
// A submission outside the frame loop: set-up, transfers of results, tests.
#pragma once

#include <functional>

#include "engine/gpu/gpu.h"

namespace airclay {

/// Records with `record`, submits, and waits.
void submitOnce(Gpu& gpu, const std::function<void(VkCommandBuffer)>& record);

}  // namespace airclay
