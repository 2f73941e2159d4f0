// SPDX-License-Identifier: MIT
// A tool defines how the hand shapes the clay. Its description (name, icon, settings) and its implementation
// are in one translation unit; engine/sculpt/tools.cpp lists all tools. The command line, recordings, panels
// and shortcuts iterate over that list, so a new tool needs no change there.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/sculpt/contact_frame.h"
#include "engine/sculpt/symmetry.h"

namespace airclay {

class Clay;
class ToolInstance;
struct ToolContext;

/// A number that the user can change.
struct ToolSetting {
  const char* id;    ///< on the command line and in recordings: "reach"
  const char* name;  ///< in the window: "Reach"
  const char* unit;  ///< "mm", or empty
  double minimum = 0, maximum = 1, initial = 0;
};

struct Tool {
  const char* id;           ///< on the command line and in recordings: "push"
  const char* name;         ///< in the window and in the history: "Push"
  const char* description;  ///< one sentence, for the tooltip
  const char* icon;         ///< strokes in SVG path syntax (M, L and C, absolute), 24 x 24, y down
  bool grabs = false;       ///< holds the clay until the clutch opens
  std::span<const ToolSetting> settings = {};
  std::unique_ptr<ToolInstance> (*create)(const ToolContext&) = nullptr;
};

/// A tool and the values of its settings.
class ToolChoice {
 public:
  /// The first tool of tools().
  ToolChoice();
  /// With the settings' initial values.
  ToolChoice(const Tool& tool);  // NOLINT: a tool is a choice

  const Tool& tool() const { return *tool_; }
  bool is(const Tool& tool) const { return tool_ == &tool; }
  /// In the order of Tool::settings.
  const std::vector<double>& values() const { return values_; }
  /// Clamped to the setting's range.
  void setValue(std::size_t setting, double value);

  bool operator==(const ToolChoice&) const = default;

 private:
  const Tool* tool_;
  std::vector<double> values_;
};

/// The user's inputs to a frame.
struct SculptControls {
  ToolChoice tool;
  Symmetry symmetry = {};
  bool held = true;             ///< the clutch is closed; if false, the clay does not move
  double frame_s = 1.0 / 30.0;  ///< time since the last frame, by the images' clock
};

/// The objects that a tool works on; all outlive the tool.
struct ToolContext {
  Gpu& gpu;
  ContactFrame& frame;
  const Clay& clay;
};

/// A tool applied to one clay. A frame consists of a first check, then displacements, solve, subdivision and
/// check, repeated until a check reports that the frame is done (contact_decide.glsl).
class ToolInstance {
 public:
  virtual ~ToolInstance() = default;

  /// The number of symmetry images of a data point that the check processes in separate workgroups.
  virtual std::uint32_t imagesPerPoint() const { return 1; }
  virtual std::uint32_t maxRepeats() const { return kContactMaxRepeats; }

  /// Records a check. `first`: right after ContactFrame::recordBegin(); otherwise the data points have moved,
  /// and the dispatches are indirect, so that they do nothing once the frame is done.
  virtual void recordCheck(Recorder& recorder, const ToolChoice& choice, double frame_s, bool first) = 0;
  /// Records the solver's right-hand side, ContactFrame::displacements(), unless the check writes it.
  virtual void recordDisplacements(Recorder&) {}

  /// For a host solver: appends the data points that the tool moves to `rows`, ascending, and returns their
  /// displacements, clay frame, metres. \pre the check's submission is done
  virtual std::vector<Vec3> displacementsOnHost(std::vector<int>& rows) const = 0;
  /// The remaining error after the frame, metres: penetration depth, or the lag of held clay.
  virtual double remainingMetres() const = 0;
};

}  // namespace airclay
