// SPDX-License-Identifier: MIT
// The sharpness and brightness of a board, from its fitted corners.
#pragma once

#include <span>

#include "capture/calibration/board.h"
#include "capture/calibration/saddle_point.h"

namespace airclay {

/// Medians over the corners. \pre corners is not empty
BoardExposure exposureOf(std::span<const SaddlePoint> corners);

}  // namespace airclay
