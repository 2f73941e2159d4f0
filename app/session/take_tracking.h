// SPDX-License-Identifier: MIT
// Tracks the hand of a take from its first frame, for the commands that only need poses.
#pragma once

#include <functional>
#include <string>

#include "capture/takes/player.h"

namespace airclay {

struct TakeTracking {
  const HandModel& hand;
  PipelineOptions pipeline;
  std::string label = "tracking";  ///< of the progress bar
  bool shows_progress = true;
};

/// Passes each frame, background included, to `receive`. \throw Interrupted (app/cli/progress.h)
void trackTake(Gpu& gpu, Recording& take, const TakeTracking& tracking,
               const std::function<void(const Pipeline&, const PlayedFrame&)>& receive);

}  // namespace airclay
