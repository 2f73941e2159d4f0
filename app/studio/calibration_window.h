// SPDX-License-Identifier: MIT
// The calibration window: each camera's image, the parts of it without board views, and what to do next.
#pragma once

#include "app/session/live_calibration.h"
#include "engine/gpu/gpu.h"

namespace airclay {

/// Runs until it is closed; the window sets `options.wake`. \return the last state
LiveCalibration::State showCalibration(Gpu& gpu, LiveCameras& cameras,
                                       const LiveCalibration::Options& options);

}  // namespace airclay
