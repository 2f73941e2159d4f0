// SPDX-License-Identifier: MIT
// The offsets between the clocks of a take's cameras, from a moving hand.
#pragma once

#include "capture/cameras/clock_offsets.h"
#include "capture/takes/take.h"
#include "engine/gpu/gpu.h"

namespace airclay {

/// Tracks the whole take for the motion that each camera saw. \throw Error like estimateClockOffsets()
ClockOffsets offsetsFromMotion(Gpu& gpu, Take& take, int voxels, bool shows_progress);

}  // namespace airclay
