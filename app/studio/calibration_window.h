// SPDX-License-Identifier: MIT
// The window in which cameras are calibrated: what each of them sees, where it has not seen the board yet,
// and what to do next.
#pragma once

#include "app/live_calibration.h"
#include "engine/gpu/gpu.h"

namespace airclay {

/// Until it is closed. What its keys and buttons want, `calibration` does. \return its last state
LiveCalibration::State showCalibration(Gpu& gpu, LiveCalibration& calibration);

/// For LiveCalibration::Options::wake: the window looks up.
void wakeCalibrationWindow();

}  // namespace airclay
