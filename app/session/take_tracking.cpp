// SPDX-License-Identifier: MIT
#include "app/session/take_tracking.h"

#include "app/cli/progress.h"

namespace airclay {

void trackTake(Gpu& gpu, Recording& take, const TakeTracking& tracking,
               const std::function<void(const Pipeline&, const PlayedFrame&)>& receive) {
  Pipeline pipeline(gpu, take.rig(), tracking.hand, tracking.pipeline);
  Player player(take, pipeline);
  Progress progress(tracking.label, take.frameCount(), tracking.shows_progress);
  while (const std::optional<PlayedFrame> frame = player.next()) {
    receive(pipeline, *frame);
    progress.advance();
  }
}

}  // namespace airclay
