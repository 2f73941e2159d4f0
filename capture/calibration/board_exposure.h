// SPDX-License-Identifier: MIT
// A board's exposure from its fitted corners.
#pragma once

#include <span>

#include "capture/calibration/board.h"
#include "capture/calibration/saddle_point.h"

namespace airclay {

/// \pre corners is not empty
BoardExposure exposureOf(std::span<const SaddlePoint> corners);

}  // namespace airclay
