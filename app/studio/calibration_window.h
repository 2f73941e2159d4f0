// SPDX-License-Identifier: MIT
// The window in which cameras are calibrated: what each of them sees, where it has not seen the board yet,
// and what to do next.
#pragma once

#include "app/session/live_calibration.h"
#include "engine/gpu/gpu.h"

namespace airclay {

/// Calibrates until it is closed, as its keys and buttons want; `options.wake` is the window's.
/// \return the last state
LiveCalibration::State showCalibration(Gpu& gpu, LiveCameras& cameras,
                                       const LiveCalibration::Options& options);

}  // namespace airclay
