// SPDX-License-Identifier: MIT
#include "engine/sculpt/sculptor.h"

namespace airclay {
namespace {

std::optional<ControlPointSolver> solverOf(Gpu& gpu, const Clay& clay) {
  if (clay.solveMethod() == SolveMethod::kTouched) return std::nullopt;
  return ControlPointSolver(gpu, clay.subdivision().matrix);
}

}  // namespace

Sculptor::Sculptor(Gpu& gpu, Clay& clay, const HandModel& hand)
    : Sculptor(gpu, clay, contactGrid(hand.skin)) {}

Sculptor::Sculptor(Gpu& gpu, Clay& clay, const DistanceGrid& hand)
    : clay_(clay),
      solver_(solverOf(gpu, clay)),
      contact_(gpu, hand, clay.evaluator().dataPointCount(), solver_ ? solver_->projectGroups() : 0,
               solver_ ? solver_->applyGroups() : 0),
      grip_(gpu, contact_.shared()),
      relaxer_(gpu, contact_.shared(), clay.subdivision()),
      keeper_(gpu),
      clay_edits_(clay.edits()) {}

/// What the hand was about holds no more when the clay, the tool or the symmetry is another.
void Sculptor::takeControls(const SculptControls& controls) {
  const bool edited = clay_edits_ != clay_.edits();
  const bool mirrored_anew = controls.symmetry != controls_.symmetry;
  if (edited || mirrored_anew || controls.tool != controls_.tool) forget();
  if (edited || mirrored_anew)
    keeper_.setOrbits(symmetryOrbits({clay_.downloadControlPoints(), clay_.cageFaces()}, controls.symmetry));
  contact_.setMirrors(mirrorsOf(controls.symmetry));
  contact_.shared().setClayFromWorkspace(clay_.workspaceFromClay().conjugate());
  clay_edits_ = clay_.edits();
  controls_ = controls;
}

void Sculptor::recordFirstCheck(Recorder& recorder, const Buffer<GpuFit>& fit) {
  if (controls_.tool == Tool::kPush) {
    contact_.recordFrame(recorder, fit, controls_.held, clay_.dataPoints());
    return;
  }
  contact_.shared().recordBegin(recorder, fit, controls_.held);
  recordCheck(recorder, true);
}

void Sculptor::recordTargets(Recorder& recorder) {
  if (controls_.tool == Tool::kPush) contact_.recordPush(recorder);
  if (controls_.tool == Tool::kPull) grip_.recordPull(recorder);
}

void Sculptor::recordCheck(Recorder& recorder, bool first) {
  if (controls_.tool == Tool::kPush)
    contact_.recordCheck(recorder, clay_.dataPoints());
  else if (controls_.tool == Tool::kPull)
    grip_.recordCheck(recorder, clay_.dataPoints(), contact_.mirrors(), first);
  else
    relaxer_.record(recorder, clay_.dataPoints(), clay_.normals(), contact_.mirrors(),
                    relaxStrength(clay_.levels(), controls_.frame_s));
}

void Sculptor::record(Recorder& recorder, const Buffer<GpuFit>& fit, const SculptControls& controls) {
  takeControls(controls);
  recordFirstCheck(recorder, fit);
  if (!onDevice()) return;
  const RawBuffer& groups = contact_.shared().groups();
  const std::uint32_t repeats = controls.tool == Tool::kSmooth ? kRelaxRepeats : kContactMaxRepeats;
  for (std::uint32_t repeat = 0; repeat < repeats; ++repeat) {
    recordTargets(recorder);
    solver_->recordIndirect(recorder, contact_.displacements(), clay_.exactPoints(), clay_.controlPoints(),
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
  return !onDevice() && contact_.summary().done == 0;
}

void Sculptor::finishOnHost(Recorder& recorder) {
  while (needsHost()) {
    moveControlPoints();
    recorder.begin();
    clay_.evaluator().recordPoints(recorder, clay_.controlPoints());
    recordCheck(recorder, false);
    clay_.evaluator().recordNormalsIndirect(recorder, contact_.shared().groups(),
                                            ContactFrame::kNormalGroups);
    recorder.submitAndWait();
  }
}

/// Of the reached rows: those that are inside go to the hand's surface, the others stay.
std::vector<Vec3> Sculptor::pushesOnHost(std::vector<int>& rows) const {
  const GpuContactFrame frame = contact_.frame();
  const ContactPose now{Eigen::Quaterniond(Eigen::Vector4d(frame.rotation_now.cast<double>())),
                        frame.position_now.cast<double>()};
  const std::vector<GpuContactPoint> points = contact_.points();
  const auto count = std::size_t(clay_.dataPointCount());
  std::vector<Vec3> displacements, wanted;
  for (std::size_t i = 0; i < count; ++i) {
    wanted.clear();
    for (std::uint32_t image = 0; image < imageCount(contact_.mirrors()); ++image) {
      const GpuContactPoint& point = points[image * count + i];
      if (point.state != kPointReached) continue;
      const Vec3 push = now.rotation * (std::max(point.depth, 0.0f) * point.direction).cast<double>();
      wanted.push_back(mirrorOf(contact_.mirrors(), image).cwiseProduct(push));
    }
    if (wanted.empty()) continue;
    rows.push_back(static_cast<int>(i));
    displacements.push_back(agreedDisplacement(wanted));
  }
  return displacements;
}

/// The rows that the tool has to do with, and what they are to do.
std::vector<Vec3> Sculptor::targetsOnHost(std::vector<int>& rows) const {
  if (controls_.tool == Tool::kPush) return pushesOnHost(rows);
  std::vector<Vec3> displacements;
  const auto add = [&](std::size_t row, const vec3& displacement) {
    rows.push_back(static_cast<int>(row));
    displacements.push_back(displacement.cast<double>());
  };
  if (controls_.tool == Tool::kPull) {
    const std::vector<GpuGripPoint> points = grip_.points();
    for (std::size_t i = 0; i < points.size(); ++i)
      if (points[i].images != 0) add(i, points[i].lag);
  } else {
    const std::vector<vec3> wanted = contact_.displacements().download();
    for (std::size_t i = 0; i < wanted.size(); ++i)
      if (wanted[i] != vec3::Zero()) add(i, wanted[i]);
  }
  return displacements;
}

/// A damped solve over these rows.
void Sculptor::moveControlPoints() {
  std::vector<int> rows;
  const std::vector<Vec3> displacements = targetsOnHost(rows);
  if (!touched_rows_ || touched_rows_->rows() != rows)
    touched_rows_.emplace(clay_.subdivision().matrix, rows, kTouchedDamping);
  const std::vector<Vec3> moved = touched_rows_->controlDisplacements(displacements);
  std::vector<Vec3> control_points = clay_.downloadControlPoints();
  for (std::size_t i = 0; i < control_points.size(); ++i) control_points[i] += moved[i];
  averageOrbits(keeper_.orbits(), control_points);
  clay_.uploadControlPoints(control_points);
}

ClayStep Sculptor::step() const {
  const GpuContactSummary& summary = contact_.summary();
  // smoothing has nothing that could be left over
  const double left_m = controls_.tool == Tool::kSmooth ? 0 : summary.depth_m;
  return {static_cast<int>(summary.touched), static_cast<int>(summary.repeats), left_m};
}

}  // namespace airclay
