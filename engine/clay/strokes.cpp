// SPDX-License-Identifier: MIT
#include "engine/clay/strokes.h"

#include <utility>

namespace airclay {

StrokeEvent StrokeWatch::see(const StrokeFrame& frame, const std::string& tool) {
  const bool backwards = frame.time_s < std::exchange(last_frame_s_, frame.time_s);
  const bool touches = frame.touched > 0 && frame.held && frame.tracked;
  if (active_) {
    // However slow the frames: a gap is one that was seen.
    const bool gap = !touches && frame.time_s - last_touch_s_ >= kStrokeGapSeconds;
    if (backwards || gap || !frame.held || !frame.tracked || tool != name_) return finish();
  } else if (touches) {
    active_ = true;
    name_ = tool;
    last_touch_s_ = frame.time_s;
    return StrokeEvent::kBegan;
  }
  if (touches) last_touch_s_ = frame.time_s;
  return StrokeEvent::kNone;
}

StrokeEvent StrokeWatch::finish() {
  return std::exchange(active_, false) ? StrokeEvent::kEnded : StrokeEvent::kNone;
}

}  // namespace airclay
