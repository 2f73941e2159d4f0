// SPDX-License-Identifier: MIT
#include "engine/clay/strokes.h"

#include <utility>

namespace airclay {

StrokeEvent StrokeDetector::addFrame(const StrokeFrame& frame, const std::string& tool) {
  const bool backwards = frame.time_s < std::exchange(last_frame_s_, frame.time_s);
  const bool touches = frame.touched > 0 && frame.held && frame.tracked;
  if (active_) {
    // Only frames without touch count as a gap, however low the frame rate.
    const bool gap = !touches && frame.time_s - last_touch_s_ >= kStrokeGapSeconds;
    if (backwards || gap || !frame.held || !frame.tracked || tool != name_) return finish();
  } else if (touches) {
    active_ = true;
    name_ = tool;
    last_touch_s_ = frame.time_s;
    return StrokeEvent::kStarted;
  }
  if (touches) last_touch_s_ = frame.time_s;
  return StrokeEvent::kNone;
}

StrokeEvent StrokeDetector::finish() {
  return std::exchange(active_, false) ? StrokeEvent::kEnded : StrokeEvent::kNone;
}

}  // namespace airclay
