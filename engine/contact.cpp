// SPDX-License-Identifier: MIT
#include "engine/contact.h"

#include "shaders/contact_begin.comp.h"
#include "shaders/contact_check.comp.h"
#include "shaders/contact_find.comp.h"
#include "shaders/contact_push.comp.h"

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

ContactFinder::ContactFinder(Gpu& gpu, const DistanceGrid& hand, std::uint32_t data_point_count,
                             std::uint32_t project_groups, std::uint32_t apply_groups)
    : grid_{hand.low_corner, hand.cell_m, hand.size, {}},
      data_point_count_(data_point_count),
      begin_(gpu, "contact_begin", contact_begin_comp),
      find_(gpu, "contact_find", contact_find_comp, {kContactWorkgroup}),
      check_(gpu, "contact_check", contact_check_comp, {gpu.reductionWorkgroup()}),
      push_(gpu, "contact_push", contact_push_comp, {kContactWorkgroup}),
      distances_(gpu, hand.values),
      points_(gpu, data_point_count),  // the first tracked frame fills all
      frame_(gpu, 1),
      summary_(gpu, 1, Memory::kHost),
      displacements_(gpu, data_point_count) {
  const GroupRows rows = groupRowsFor(data_point_count, kContactWorkgroup);
  groups_ = {rows.x, rows.y, project_groups, apply_groups};
}

void ContactFinder::recordFind(Recorder& recorder, const Buffer<vec3>& data_points, bool first) {
  ContactFindArgs find{};
  find.distances = distances_;
  find.frame = frame_;
  find.data_points = data_points;
  find.points = points_;
  find.low_corner = grid_.low_corner.cast<float>();
  find.cell_m = static_cast<float>(grid_.cell_m);
  find.size_x = static_cast<std::uint32_t>(grid_.size[0]);
  find.size_y = static_cast<std::uint32_t>(grid_.size[1]);
  find.size_z = static_cast<std::uint32_t>(grid_.size[2]);
  find.data_point_count = data_point_count_;
  find.first = first ? 1 : 0;
  recorder.dispatchIndirect(find_, find, frame_.raw(), kPointGroups);

  ContactCheckArgs check{};
  check.points = points_;
  check.frame = frame_;
  check.summary = summary_;
  check.groups = groups_;
  check.data_point_count = data_point_count_;
  recorder.dispatchIndirect(check_, check, frame_.raw(), kCheckGroups);
}

void ContactFinder::recordFrame(Recorder& recorder, const Buffer<GpuFit>& fit, bool held,
                                const Buffer<vec3>& data_points) {
  ContactBeginArgs begin{};
  begin.fit = fit;
  begin.frame = frame_;
  begin.groups = groups_;
  begin.held = held ? 1 : 0;
  begin.forget = forget_ ? 1 : 0;
  forget_ = false;
  recorder.dispatch(begin_, begin, 1);
  recordFind(recorder, data_points, true);
}

void ContactFinder::recordPush(Recorder& recorder) {
  ContactPushArgs push{};
  push.frame = frame_;
  push.points = points_;
  push.displacements = displacements_;
  push.data_point_count = data_point_count_;
  recorder.dispatchIndirect(push_, push, frame_.raw(), kPointGroups);
}

void ContactFinder::recordCheck(Recorder& recorder, const Buffer<vec3>& data_points) {
  recordFind(recorder, data_points, false);
}

}  // namespace airclay
