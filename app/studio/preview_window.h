// SPDX-License-Identifier: MIT
// The window of `airclay cameras --watch`: what each camera sees, and how it runs.
#pragma once

#include <functional>

#include "capture/cameras/live_cameras.h"
#include "engine/gpu/gpu.h"

namespace airclay {

/// Until it is closed, or `goes_on`, which is told of every set and several times a second of none, is false.
void watchCameras(Gpu& gpu, LiveCameras& cameras, const std::function<bool(const LiveSet*)>& goes_on);

}  // namespace airclay
