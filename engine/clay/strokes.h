// SPDX-License-Identifier: MIT
// When a stroke begins and ends, so that it becomes one named entry of the history.
#pragma once

#include <string>

namespace airclay {

/// What a frame did to the clay.
struct StrokeFrame {
  double time_s = 0;    ///< the frame's own time: a replay makes the same strokes
  int touched = 0;      ///< data points that the hand has reached
  bool held = true;     ///< the clutch
  bool tracked = true;  ///< the hand is known in this frame
};

enum class StrokeEvent {
  kNone,
  kBegan,  ///< in this frame: the clay of before it is what undo goes back to
  kEnded,  ///< with the frame before this one or in this one: the clay as it stands is the entry
};

/// Watches frames. A stroke begins when the hand touches the clay, held and tracked. It ends when nothing was
/// touched for kStrokeGapSeconds, the clutch opens, tracking is lost, or time runs backwards (a take begins
/// again).
class StrokeWatch {
 public:
  /// 0.4 s: longer than the lift between two dabs, shorter than a look at the result.
  static constexpr double kStrokeGapSeconds = 0.4;

  /// The next frame. `tool` names the stroke that it may begin ("Push"); a stroke that is under way keeps its
  /// name, and ends when another tool is given.
  StrokeEvent see(const StrokeFrame& frame, const std::string& tool);
  /// Ends the stroke that is under way, if any: before undo, saving, another document, at the end of a take.
  StrokeEvent finish();

  bool active() const { return active_; }
  /// Of the stroke that is under way or else ended last.
  const std::string& name() const { return name_; }

 private:
  bool active_ = false;
  std::string name_;
  double last_touch_s_ = 0, last_frame_s_ = 0;
};

}  // namespace airclay
