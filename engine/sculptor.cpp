// SPDX-License-Identifier: MIT
#include "engine/sculptor.h"

namespace airclay {
namespace {

std::optional<ControlPointSolver> solverOf(Gpu& gpu, const Clay& clay) {
  if (clay.solveRows() == SolveRows::kTouched) return std::nullopt;
  return ControlPointSolver(gpu, clay.subdivision().matrix);
}

}  // namespace

Sculptor::Sculptor(Gpu& gpu, Clay& clay, const HandModel& hand)
    : clay_(clay),
      solver_(solverOf(gpu, clay)),
      contact_(gpu, contactGrid(hand.skin), clay.evaluator().dataPointCount(),
               solver_ ? solver_->projectGroups() : 0, solver_ ? solver_->applyGroups() : 0),
      clay_edits_(clay.edits()) {}

void Sculptor::record(Recorder& recorder, const Buffer<GpuFit>& fit, bool held) {
  if (clay_edits_ != clay_.edits()) forget();
  clay_edits_ = clay_.edits();
  contact_.recordFrame(recorder, fit, held, clay_.dataPoints());
  if (!onDevice()) return;
  for (std::uint32_t repeat = 0; repeat < kContactMaxRepeats; ++repeat) {
    contact_.recordPush(recorder);
    solver_->recordIndirect(recorder, contact_.displacements(), clay_.exactPoints(), clay_.controlPoints(),
                            contact_.groups(), ContactFinder::kProjectGroups, ContactFinder::kApplyGroups);
    clay_.evaluator().recordPointsIndirect(recorder, clay_.controlPoints(), contact_.groups(),
                                           ContactFinder::kPointGroups);
    contact_.recordCheck(recorder, clay_.dataPoints());
  }
  clay_.evaluator().recordNormalsIndirect(recorder, contact_.groups(), ContactFinder::kNormalGroups);
}

bool Sculptor::needsHost() const {
  return !onDevice() && contact_.summary().done == 0;
}

void Sculptor::finishOnHost(Recorder& recorder) {
  while (needsHost()) {
    moveControlPoints();
    recorder.begin();
    clay_.evaluator().recordPoints(recorder, clay_.controlPoints());
    contact_.recordCheck(recorder, clay_.dataPoints());
    clay_.evaluator().recordNormalsIndirect(recorder, contact_.groups(), ContactFinder::kNormalGroups);
    recorder.submitAndWait();
  }
}

/// A damped solve over the reached rows: those that are inside go to the hand's surface, the others stay.
void Sculptor::moveControlPoints() {
  const GpuContactFrame frame = contact_.frame();
  const ContactPose now{Eigen::Quaterniond(Eigen::Vector4d(frame.rotation_now.cast<double>())),
                        frame.position_now.cast<double>()};
  const std::vector<GpuContactPoint> points = contact_.points();
  std::vector<int> rows;
  std::vector<Vec3> displacements;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].state != kPointReached) continue;
    rows.push_back(static_cast<int>(i));
    displacements.push_back(now.rotation *
                            (std::max(points[i].depth, 0.0f) * points[i].direction).cast<double>());
  }
  if (!touched_rows_ || touched_rows_->rows() != rows)
    touched_rows_.emplace(clay_.subdivision().matrix, rows, kTouchedDamping);
  const std::vector<Vec3> moved = touched_rows_->controlDisplacements(displacements);
  std::vector<Vec3> control_points = clay_.downloadControlPoints();
  for (std::size_t i = 0; i < control_points.size(); ++i) control_points[i] += moved[i];
  clay_.uploadControlPoints(control_points);
}

ClayStep Sculptor::step() const {
  const GpuContactSummary& summary = contact_.summary();
  return {static_cast<int>(summary.touched), static_cast<int>(summary.repeats), summary.depth_m};
}

}  // namespace airclay
