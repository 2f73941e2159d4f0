// SPDX-License-Identifier: MIT
// Detects where strokes start and end, so that each becomes one named entry of the history.
#pragma once

#include <string>

namespace airclay {

/// A frame's effect on the clay.
struct StrokeFrame {
  double time_s = 0;    ///< the frame's timestamp, so that a replay yields the same strokes
  int touched = 0;      ///< number of data points that the hand touches
  bool held = true;     ///< the clutch is closed
  bool tracked = true;  ///< the hand is tracked in this frame
};

enum class StrokeEvent {
  kNone,
  kStarted,  ///< in this frame; undo restores the clay from before it
  kEnded,    ///< with this frame or the previous one; the current clay becomes the entry
};

/// A stroke starts when the hand touches the clay with the clutch closed and the hand tracked. It ends when
/// nothing is touched for kStrokeGapSeconds, the clutch opens, tracking is lost, or time runs backwards (a
/// take restarts).
class StrokeDetector {
 public:
  /// 0.4 s: longer than the gap between two dabs, shorter than a pause to look at the result.
  static constexpr double kStrokeGapSeconds = 0.4;

  /// Processes the next frame. `tool` names a stroke that it starts ("Push"); an active stroke keeps its
  /// name, and ends when the tool changes.
  StrokeEvent addFrame(const StrokeFrame& frame, const std::string& tool);
  /// Ends the active stroke, if any: before undo, saving or another document, and at the end of a take.
  StrokeEvent finish();

  bool active() const { return active_; }
  /// The name of the active stroke, or of the last one.
  const std::string& name() const { return name_; }

 private:
  bool active_ = false;
  std::string name_;
  double last_touch_s_ = 0, last_frame_s_ = 0;
};

}  // namespace airclay
