// SPDX-License-Identifier: MIT
#include "engine/sculpt/grip.h"

#include "shaders/sculpt/grip_check.comp.h"
#include "shaders/sculpt/grip_find.comp.h"
#include "shaders/sculpt/grip_pull.comp.h"

namespace airclay {

Grip::Grip(Gpu& gpu, const ContactFrame& frame)
    : frame_(frame),
      find_(gpu, "grip_find", grip_find_comp, {kContactWorkgroup}),
      check_(gpu, "grip_check", grip_check_comp, {gpu.reductionWorkgroup()}),
      pull_(gpu, "grip_pull", grip_pull_comp, {kContactWorkgroup}),
      points_(gpu, frame.dataPointCount()) {}  // filled until the hand takes hold

void Grip::recordCheck(Recorder& recorder, const Buffer<vec3>& data_points, std::uint32_t mirrors,
                       bool first) {
  GripFindArgs find{};
  find.frame = frame_.state();
  find.data_points = data_points;
  find.points = points_;
  find.data_point_count = frame_.dataPointCount();
  find.mirrors = mirrors;
  find.first = first ? 1 : 0;
  find.hand = frame_.hand();
  recorder.dispatchIndirect(find_, find, frame_.groups(), ContactFrame::kFindGroups);

  GripCheckArgs check{};
  check.points = points_;
  check.data_point_count = frame_.dataPointCount();
  check.decision = frame_.decision(kGripLagWanted_m, kContactMaxRepeats, kGripMaxStalls);
  recorder.dispatchIndirect(check_, check, frame_.groups(), ContactFrame::kCheckGroups);
}

void Grip::recordPull(Recorder& recorder) {
  GripPullArgs pull{};
  pull.frame = frame_.state();
  pull.points = points_;
  pull.displacements = frame_.displacements();
  pull.data_point_count = frame_.dataPointCount();
  recorder.dispatchIndirect(pull_, pull, frame_.groups(), ContactFrame::kPointGroups);
}

}  // namespace airclay
