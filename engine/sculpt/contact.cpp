// SPDX-License-Identifier: MIT
#include "engine/sculpt/contact.h"

#include "shaders/sculpt/contact_begin.comp.h"
#include "shaders/sculpt/contact_check.comp.h"
#include "shaders/sculpt/contact_find.comp.h"
#include "shaders/sculpt/contact_push.comp.h"

namespace airclay {
namespace {

/// A fifth of a finger's width: the grid rounds off no more than that. The hand takes 1.5 MB.
constexpr double kCell_m = 0.0025;
/// Outside, distances go on from the border: far enough that their bend does not matter.
constexpr double kMargin_m = 0.03;

}  // namespace

DistanceGrid contactGrid(const TriangleMesh& skin) {
  DistanceGrid grid = signedDistanceGrid(skin, kCell_m, kMargin_m);
  grid.low_corner -= massProperties(skin).centroid;
  return grid;
}

ContactFrame::ContactFrame(Gpu& gpu, const DistanceGrid& hand, std::uint32_t data_point_count,
                           std::uint32_t project_groups, std::uint32_t apply_groups)
    : grid_{hand.low_corner, hand.cell_m, hand.size, {}},
      begin_(gpu, "contact_begin", contact_begin_comp),
      distances_(gpu, hand.values),
      state_(gpu, 1),
      summary_(gpu, 1, Memory::kHost),
      displacements_(gpu, data_point_count) {
  const GroupRows rows = groupRowsFor(data_point_count, kContactWorkgroup);
  groups_ = {rows.x, rows.y, project_groups, apply_groups, 1};
}

void ContactFrame::recordBegin(Recorder& recorder, const Buffer<GpuFit>& fit, bool held,
                               std::uint32_t images) {
  groups_.images = images;
  ContactBeginArgs begin{};
  begin.fit = fit;
  begin.frame = state_;
  begin.clay_from_workspace = clay_from_workspace_.coeffs().cast<float>();
  begin.groups = groups_;
  begin.held = held ? 1 : 0;
  begin.forget = forget_ ? 1 : 0;
  forget_ = false;
  recorder.dispatch(begin_, begin, 1);
}

HandDistances ContactFrame::hand() const {
  HandDistances hand{};
  hand.values = distances_;
  hand.low_corner = grid_.low_corner.cast<float>();
  hand.cell_m = static_cast<float>(grid_.cell_m);
  hand.size_x = static_cast<std::uint32_t>(grid_.size[0]);
  hand.size_y = static_cast<std::uint32_t>(grid_.size[1]);
  hand.size_z = static_cast<std::uint32_t>(grid_.size[2]);
  return hand;
}

ContactDecision ContactFrame::decision(float target_m, std::uint32_t max_repeats,
                                       std::uint32_t max_stalls) const {
  ContactDecision decision{};
  decision.frame = state_;
  decision.summary = summary_;
  decision.groups = groups_;
  decision.target_m = target_m;
  decision.max_repeats = max_repeats;
  decision.max_stalls = max_stalls;
  return decision;
}

ContactFinder::ContactFinder(Gpu& gpu, const DistanceGrid& hand, std::uint32_t data_point_count,
                             std::uint32_t project_groups, std::uint32_t apply_groups)
    : gpu_(gpu),
      frame_(gpu, hand, data_point_count, project_groups, apply_groups),
      find_(gpu, "contact_find", contact_find_comp, {kContactWorkgroup}),
      check_(gpu, "contact_check", contact_check_comp, {gpu.reductionWorkgroup()}),
      push_(gpu, "contact_push", contact_push_comp, {kContactWorkgroup}),
      points_(gpu, data_point_count) {}  // the first tracked frame fills all

void ContactFinder::setMirrors(std::uint32_t mirrors) {
  if (mirrors == mirrors_) return;
  mirrors_ = mirrors;
  points_ = Buffer<GpuContactPoint>(gpu_, std::size_t(frame_.dataPointCount()) * imageCount(mirrors));
  forget();
}

void ContactFinder::recordFind(Recorder& recorder, const Buffer<vec3>& data_points, bool first) {
  ContactFindArgs find{};
  find.frame = frame_.state();
  find.data_points = data_points;
  find.points = points_;
  find.mirrors = mirrors_;
  find.data_point_count = frame_.dataPointCount();
  find.first = first ? 1 : 0;
  find.hand = frame_.hand();
  recorder.dispatchIndirect(find_, find, frame_.groups(), ContactFrame::kFindGroups);

  ContactCheckArgs check{};
  check.points = points_;
  check.point_count = static_cast<std::uint32_t>(points_.count());
  check.decision = frame_.decision(kContactDepthWanted, kContactMaxRepeats);
  recorder.dispatchIndirect(check_, check, frame_.groups(), ContactFrame::kCheckGroups);
}

void ContactFinder::recordFrame(Recorder& recorder, const Buffer<GpuFit>& fit, bool held,
                                const Buffer<vec3>& data_points) {
  frame_.recordBegin(recorder, fit, held, imageCount(mirrors_));
  recordFind(recorder, data_points, true);
}

void ContactFinder::recordPush(Recorder& recorder) {
  ContactPushArgs push{};
  push.frame = frame_.state();
  push.points = points_;
  push.displacements = frame_.displacements();
  push.data_point_count = frame_.dataPointCount();
  push.mirrors = mirrors_;
  recorder.dispatchIndirect(push_, push, frame_.groups(), ContactFrame::kPointGroups);
}

void ContactFinder::recordCheck(Recorder& recorder, const Buffer<vec3>& data_points) {
  recordFind(recorder, data_points, false);
}

}  // namespace airclay
