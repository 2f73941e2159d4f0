// SPDX-License-Identifier: MIT
// Sculpting: a tool's check, solve and subdivision, repeated within a frame until the surface is outside the
// hand or has followed it.
#pragma once

#include <memory>

#include "engine/clay/clay.h"
#include "engine/hand/hand_model.h"
#include "engine/sculpt/tools.h"

namespace airclay {

/// A frame's effect on the clay.
struct ClayStep {
  int touched = 0;           ///< data points that the tool moves; *push* counts each symmetry image
  int repeats = 0;           ///< repeats of check and solve
  double penetration_m = 0;  ///< the remaining depth; for *pull*, the lag of held points
};

/// With a device solver, a frame is part of one submission: all repeats are recorded, and those that are not
/// needed dispatch nothing. With a host solver, each repeat is a separate submission.
class Sculptor {
 public:
  Sculptor(Gpu& gpu, Clay& clay, const HandModel& hand);
  /// `hand`: contactGrid() of its skin, which takes a while to compute.
  Sculptor(Gpu& gpu, Clay& clay, const DistanceGrid& hand);

  /// Records a frame: element 0 of `hands` is the sculpting hand. The clay moves only if the hand was tracked
  /// and the clutch closed in this frame and the last, with the same tool and symmetry. \pre earlier recorded
  /// work is done
  void record(Recorder& recorder, const Buffer<GpuHandPose>& hands, const SculptControls& controls = {});
  /// After the submission: whether finishOnHost() has work to do.
  bool needsHost() const;
  /// Performs the repeats of a host solver. \pre the recorder's submission is done
  void finishOnHost(Recorder& recorder);
  /// After the submission and finishOnHost().
  ClayStep step() const;
  /// The next frame starts as if tracking had just begun.
  void forget() { frame_.forget(); }

 private:
  void setControls(const SculptControls& controls);
  void recordCheck(Recorder& recorder, bool first);
  void moveControlPoints();
  const ToolInstance& tool() const { return *tools_[current_]; }
  ToolInstance& tool() { return *tools_[current_]; }

  Clay& clay_;
  std::unique_ptr<ClaySolver> solver_;
  ContactFrame frame_;
  std::vector<std::unique_ptr<ToolInstance>> tools_;  ///< in the order of tools()
  std::size_t current_ = 0;                           ///< the last frame's tool
  SymmetryKeeper keeper_;
  SculptControls controls_;  ///< of the last frame
  int clay_edits_;
};

}  // namespace airclay
