// SPDX-License-Identifier: MIT
// The hand sculpts the clay: contact, solve and subdivision, repeated within a frame until the surface has
// come out of the hand, or followed it.
#pragma once

#include <memory>
#include <optional>

#include "engine/clay/clay.h"
#include "engine/hand/hand_model.h"
#include "engine/sculpt/contact.h"
#include "engine/sculpt/grip.h"
#include "engine/sculpt/relax.h"
#include "engine/sculpt/tools.h"

namespace airclay {

/// What became of the clay in a frame.
struct ClayStep {
  int touched = 0;           ///< data points that the tool has to do with; *push* counts each image's
  int repeats = 0;           ///< of contact and solve
  double penetration_m = 0;  ///< what is left of it; with *pull* how far a held point lags behind
};

/// With SolveMethod::kAll a frame is part of one submission: all repeats are recorded, and those that are not
/// needed dispatch nothing. With kTouched the rows change from repeat to repeat, so they are done on the
/// host, each with a submission of its own.
class Sculptor {
 public:
  Sculptor(Gpu& gpu, Clay& clay, const HandModel& hand);
  /// With the hand's contactGrid(), which takes a while to make.
  Sculptor(Gpu& gpu, Clay& clay, const DistanceGrid& hand);

  /// Records a frame: element 0 of `fit` is where the hand is. The clay moves only where the hand was tracked
  /// and held in this frame and the last, with the same tool and symmetry. \pre nothing recorded before is
  /// still running
  void record(Recorder& recorder, const Buffer<GpuFit>& fit, const SculptControls& controls = {});
  /// After the submission: whether finishOnHost() has work to do.
  bool needsHost() const;
  /// The repeats of kTouched. \pre the recorder's submission is done
  void finishOnHost(Recorder& recorder);
  /// After the submission and finishOnHost().
  ClayStep step() const;
  /// The next frame starts anew, as if tracking began.
  void forget() { contact_.forget(); }

 private:
  bool onDevice() const { return solver_.has_value(); }
  void takeControls(const SculptControls& controls);
  void recordFirstCheck(Recorder& recorder, const Buffer<GpuFit>& fit);
  void recordTargets(Recorder& recorder);
  void recordCheck(Recorder& recorder, bool first);
  std::vector<Vec3> targetsOnHost(std::vector<int>& rows) const;
  std::vector<Vec3> pushesOnHost(std::vector<int>& rows) const;
  void moveControlPoints();

  Clay& clay_;
  std::optional<ControlPointSolver> solver_;       ///< kAll
  std::optional<TouchedRowsSolver> touched_rows_;  ///< kTouched, of the last repeat
  ContactFinder contact_;
  Grip grip_;
  Relaxer relaxer_;
  SymmetryKeeper keeper_;
  SculptControls controls_;  ///< of the last frame
  int clay_edits_;
};

}  // namespace airclay
