// SPDX-License-Identifier: MIT
#include "engine/sculpt/contact_frame.h"

#include "shaders/sculpt/contact_begin.comp.h"

namespace airclay {
namespace {

/// An eighth of a finger's width, which limits how much the grid rounds off. The hand's grid takes 1.5 MB.
constexpr double kCell_m = 0.0025;
/// Outside the grid, distances are extrapolated from its border, where the error no longer matters.
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

void ContactFrame::recordBegin(Recorder& recorder, const Buffer<GpuHandPose>& hands, bool held,
                               std::uint32_t images) {
  groups_.images = images;
  ContactBeginArgs begin{};
  begin.hand = hands;
  begin.frame = state_;
  begin.clay_from_workspace = clay_from_workspace_.coeffs().cast<float>();
  begin.groups = groups_;
  begin.held = held ? 1 : 0;
  begin.forget = forget_ ? 1 : 0;
  forget_ = false;
  recorder.dispatch(begin_, begin, 1);
}

void ContactFrame::setMirrors(std::uint32_t mirrors) {
  if (mirrors == mirrors_) return;
  mirrors_ = mirrors;
  forget();
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

}  // namespace airclay
