// SPDX-License-Identifier: MIT
// The hand sculpts the clay: a tool's check, solve and subdivision, repeated within a frame until the surface
// is out of the hand, or has followed it.
#pragma once

#include <memory>

#include "engine/clay/clay.h"
#include "engine/hand/hand_model.h"
#include "engine/sculpt/tools.h"

namespace airclay {

/// What a frame did to the clay.
struct ClayStep {
  int touched = 0;           ///< data points that the tool moves; *push* counts each symmetry image
  int repeats = 0;           ///< of check and solve
  double penetration_m = 0;  ///< what is left of it; with *pull* the lag of held points
};

/// With a solver on the device a frame is part of one submission: all repeats are recorded, and those that
/// are not needed dispatch nothing. With a solver on the host each repeat is a submission of its own.
class Sculptor {
 public:
  Sculptor(Gpu& gpu, Clay& clay, const HandModel& hand);
  /// With the hand's contactGrid(), which takes a while to compute.
  Sculptor(Gpu& gpu, Clay& clay, const DistanceGrid& hand);

  /// Records a frame: element 0 of `hands` is the hand that sculpts. The clay moves only where the hand was
  /// tracked and held in this frame and the last, with the same tool and symmetry. \pre nothing recorded
  /// before is still running
  void record(Recorder& recorder, const Buffer<GpuHandPose>& hands, const SculptControls& controls = {});
  /// After the submission: whether finishOnHost() has work to do.
  bool needsHost() const;
  /// The repeats of a solver on the host. \pre the recorder's submission is done
  void finishOnHost(Recorder& recorder);
  /// After the submission and finishOnHost().
  ClayStep step() const;
  /// The next frame starts over, as if tracking began.
  void forget() { frame_.forget(); }

 private:
  void takeControls(const SculptControls& controls);
  void recordCheck(Recorder& recorder, bool first);
  void moveControlPoints();
  const ToolInstance& tool() const { return *tools_[current_]; }
  ToolInstance& tool() { return *tools_[current_]; }

  Clay& clay_;
  std::unique_ptr<ClaySolver> solver_;
  ContactFrame frame_;
  std::vector<std::unique_ptr<ToolInstance>> tools_;  ///< as tools()
  std::size_t current_ = 0;                           ///< the last frame's
  SymmetryKeeper keeper_;
  SculptControls controls_;  ///< of the last frame
  int clay_edits_;
};

}  // namespace airclay
