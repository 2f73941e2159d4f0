// SPDX-License-Identifier: MIT
#include "engine/sculpt/sculptor.h"

#include <algorithm>

namespace airclay {

Sculptor::Sculptor(Gpu& gpu, Clay& clay, const HandModel& hand)
    : Sculptor(gpu, clay, contactGrid(hand.skin)) {}

Sculptor::Sculptor(Gpu& gpu, Clay& clay, const DistanceGrid& hand)
    : clay_(clay),
      solver_(clay.solveMethod().create(gpu, clay.subdivision().matrix)),
      frame_(gpu, hand, clay.evaluator().dataPointCount(), solver_->projectGroups(), solver_->applyGroups()),
      keeper_(gpu),
      clay_edits_(clay.edits()) {
  for (const Tool* tool : airclay::tools()) tools_.push_back(tool->create({gpu, frame_, clay}));
}

/// A change of the clay, the tool or the symmetry implies forget().
void Sculptor::setControls(const SculptControls& controls) {
  const bool edited = clay_edits_ != clay_.edits();
  const bool symmetry_changed = controls.symmetry != controls_.symmetry;
  if (edited || symmetry_changed || !controls.tool.is(controls_.tool.tool())) forget();
  if (edited || symmetry_changed)
    keeper_.setOrbits(symmetryOrbits({clay_.downloadControlPoints(), clay_.cageFaces()}, controls.symmetry));
  frame_.setMirrors(mirrorsOf(controls.symmetry));
  frame_.setClayFromWorkspace(clay_.workspaceFromClay().conjugate());
  clay_edits_ = clay_.edits();
  controls_ = controls;
  current_ =
      std::size_t(std::ranges::find(airclay::tools(), &controls.tool.tool()) - airclay::tools().begin());
}

void Sculptor::recordCheck(Recorder& recorder, bool first) {
  tool().recordCheck(recorder, controls_.tool, controls_.frame_s, first);
}

void Sculptor::record(Recorder& recorder, const Buffer<GpuHandPose>& hands, const SculptControls& controls) {
  setControls(controls);
  frame_.recordBegin(recorder, hands, controls_.held, tool().imagesPerPoint());
  recordCheck(recorder, true);
  if (!solver_->onDevice()) return;
  const RawBuffer& groups = frame_.groups();
  for (std::uint32_t repeat = 0; repeat < tool().maxRepeats(); ++repeat) {
    tool().recordDisplacements(recorder);
    solver_->recordIndirect(recorder, frame_.displacements(), clay_.exactPoints(), clay_.controlPoints(),
                            groups, ContactFrame::kProjectGroups, ContactFrame::kApplyGroups);
    keeper_.recordIndirect(recorder, clay_.exactPoints(), clay_.controlPoints(), groups,
                           ContactFrame::kApplyGroups);
    clay_.evaluator().recordPointsIndirect(recorder, clay_.controlPoints(), groups,
                                           ContactFrame::kPointGroups);
    recordCheck(recorder, false);
  }
  clay_.evaluator().recordNormalsIndirect(recorder, groups, ContactFrame::kNormalGroups);
}

bool Sculptor::needsHost() const {
  return !solver_->onDevice() && frame_.summary().done == 0;
}

void Sculptor::finishOnHost(Recorder& recorder) {
  while (needsHost()) {
    moveControlPoints();
    recorder.begin();
    clay_.evaluator().recordPoints(recorder, clay_.controlPoints());
    recordCheck(recorder, false);
    clay_.evaluator().recordNormalsIndirect(recorder, frame_.groups(), ContactFrame::kNormalGroups);
    recorder.submitAndWait();
  }
}

void Sculptor::moveControlPoints() {
  std::vector<int> rows;
  const std::vector<Vec3> displacements = tool().displacementsOnHost(rows);
  const std::vector<Vec3> moved = solver_->controlDisplacements(rows, displacements);
  std::vector<Vec3> control_points = clay_.downloadControlPoints();
  for (std::size_t i = 0; i < control_points.size(); ++i) control_points[i] += moved[i];
  averageOrbits(keeper_.orbits(), control_points);
  clay_.uploadControlPoints(control_points);
}

ClayStep Sculptor::step() const {
  const GpuContactSummary& summary = frame_.summary();
  return {static_cast<int>(summary.touched), static_cast<int>(summary.repeats), tool().remainingMetres()};
}

}  // namespace airclay
