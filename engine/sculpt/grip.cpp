// SPDX-License-Identifier: MIT
#include "engine/sculpt/grip.h"

#include "engine/clay/clay.h"
#include "shaders/sculpt/grip_check.comp.h"
#include "shaders/sculpt/grip_find.comp.h"
#include "shaders/sculpt/grip_pull.comp.h"

namespace airclay {
namespace {

constexpr ToolSetting kSettings[] = {
    {.id = "reach", .name = "Reach", .unit = "mm", .minimum = 2, .maximum = 40, .initial = 6}};

class PullTool final : public ToolInstance {
 public:
  explicit PullTool(const ToolContext& context)
      : frame_(context.frame), clay_(context.clay), grip_(context.gpu, context.frame) {}

  void recordCheck(Recorder& recorder, const ToolChoice& choice, double, bool first) override {
    grip_.recordCheck(recorder, clay_.dataPoints(), first, 1e-3 * choice.values()[0]);
  }
  void recordDisplacements(Recorder& recorder) override { grip_.recordPull(recorder); }
  std::vector<Vec3> displacementsOnHost(std::vector<int>& rows) const override {
    std::vector<Vec3> displacements;
    const std::vector<GpuGripPoint> points = grip_.points();
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (points[i].images == 0) continue;
      rows.push_back(static_cast<int>(i));
      displacements.emplace_back(points[i].lag.cast<double>());
    }
    return displacements;
  }
  double remainingMetres() const override { return frame_.summary().depth_m; }

 private:
  const ContactFrame& frame_;
  const Clay& clay_;
  Grip grip_;
};

std::unique_ptr<ToolInstance> createPullTool(const ToolContext& context) {
  return std::make_unique<PullTool>(context);
}

}  // namespace

const Tool kPullTool = {
    .id = "pull",
    .name = "Pull",
    .description = "Touched clay sticks to the hand and follows it",
    // a peak in a surface, and an arrow out of it
    .icon = "M2 20 L6 20 C10 20 10 13 12 13 C14 13 14 20 18 20 L22 20 M12 13 L12 3 M8 7 L12 3 L16 7",
    .grabs = true,
    .settings = kSettings,
    .create = createPullTool,
};

Grip::Grip(Gpu& gpu, const ContactFrame& frame)
    : frame_(frame),
      find_(gpu, "grip_find", grip_find_comp, {kContactWorkgroup}),
      check_(gpu, "grip_check", grip_check_comp, {gpu.reductionWorkgroup()}),
      pull_(gpu, "grip_pull", grip_pull_comp, {kContactWorkgroup}),
      points_(gpu, frame.dataPointCount()) {}  // written in each frame until the hand grabs

void Grip::recordCheck(Recorder& recorder, const Buffer<vec3>& data_points, bool first, double reach_m) {
  GripFindArgs find{};
  find.frame = frame_.state();
  find.data_points = data_points;
  find.points = points_;
  find.data_point_count = frame_.dataPointCount();
  find.mirrors = frame_.mirrors();
  find.first = first ? 1 : 0;
  find.reach_m = static_cast<float>(reach_m);
  find.hand = frame_.hand();
  recorder.dispatchIndirect(find_, find, frame_.groups(), ContactFrame::kFindGroups);

  GripCheckArgs check{};
  check.points = points_;
  check.data_point_count = frame_.dataPointCount();
  check.decision = frame_.decision(kGripTargetLag_m, kContactMaxRepeats, kGripMaxStalls);
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
