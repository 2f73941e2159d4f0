// SPDX-License-Identifier: MIT
// The window of `airclay cameras --watch`: the image and status of each camera.
#pragma once

#include <functional>

#include "capture/cameras/live_cameras.h"
#include "engine/gpu/gpu.h"

namespace airclay {

/// Runs until the window is closed or `goes_on` returns false. `goes_on` is called with every set, and
/// several times per second with null.
void watchCameras(Gpu& gpu, LiveCameras& cameras, const std::function<bool(const LiveSet*)>& goes_on);

}  // namespace airclay
