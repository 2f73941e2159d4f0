// SPDX-License-Identifier: MIT
// The hand sculpts the clay: contact, solve and subdivision, repeated within a frame until the surface has
// come out of the hand.
#pragma once

#include <memory>
#include <optional>

#include "engine/clay.h"
#include "engine/contact.h"
#include "engine/hand_model.h"
#include "engine/pipeline.h"

namespace airclay {

/// With SolveRows::kAll a frame is part of one submission: all repeats are recorded, and those that are not
/// needed dispatch nothing. With kTouched the rows change from repeat to repeat, so they are done on the
/// host, each with a submission of its own.
class Sculptor {
 public:
  Sculptor(Gpu& gpu, Clay& clay, const HandModel& hand);

  /// Records a frame: element 0 of `fit` is where the hand is, `held` the clutch. The clay moves only where
  /// the hand was tracked and held in this frame and the last.
  void record(Recorder& recorder, const Buffer<GpuFit>& fit, bool held);
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
  void moveControlPoints();

  Clay& clay_;
  std::optional<ControlPointSolver> solver_;       ///< kAll
  std::optional<TouchedRowsSolver> touched_rows_;  ///< kTouched, of the last repeat
  ContactFinder contact_;
  int clay_edits_;
};

}  // namespace airclay
