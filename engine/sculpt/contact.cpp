// SPDX-License-Identifier: MIT
#include "engine/sculpt/contact.h"

#include "engine/clay/clay.h"
#include "shaders/sculpt/contact_check.comp.h"
#include "shaders/sculpt/contact_find.comp.h"
#include "shaders/sculpt/contact_push.comp.h"

namespace airclay {
namespace {

class PushTool final : public ToolInstance {
 public:
  explicit PushTool(const ToolContext& context)
      : frame_(context.frame), clay_(context.clay), finder_(context.gpu, context.frame) {}

  std::uint32_t imagesPerPoint() const override { return imageCount(frame_.mirrors()); }
  void recordCheck(Recorder& recorder, const ToolChoice&, double, bool first) override {
    finder_.recordCheck(recorder, clay_.dataPoints(), first);
  }
  void recordDisplacements(Recorder& recorder) override { finder_.recordPush(recorder); }

  /// The reached points: those inside move to the hand's surface, the others stay.
  std::vector<Vec3> displacementsOnHost(std::vector<int>& rows) const override {
    const GpuContactFrame frame = frame_.state().download()[0];
    const Eigen::Quaterniond rotation(Eigen::Vector4d(frame.rotation_now.cast<double>()));
    const std::vector<GpuContactPoint> points = finder_.points();
    const auto count = std::size_t(clay_.dataPointCount());
    const std::uint32_t mirrors = frame_.mirrors();
    std::vector<Vec3> displacements, requested;
    for (std::size_t i = 0; i < count; ++i) {
      requested.clear();
      for (std::uint32_t image = 0; image < imageCount(mirrors); ++image) {
        const GpuContactPoint& point = points[image * count + i];
        if (point.state != kPointReached) continue;
        const Vec3 push = rotation * (std::max(point.depth, 0.0f) * point.direction).cast<double>();
        requested.push_back(mirrorOf(mirrors, image).cwiseProduct(push));
      }
      if (requested.empty()) continue;
      rows.push_back(static_cast<int>(i));
      displacements.push_back(combinedDisplacement(requested));
    }
    return displacements;
  }
  double remainingMetres() const override { return frame_.summary().depth_m; }

 private:
  const ContactFrame& frame_;
  const Clay& clay_;
  ContactFinder finder_;
};

std::unique_ptr<ToolInstance> createPushTool(const ToolContext& context) {
  return std::make_unique<PushTool>(context);
}

}  // namespace

const Tool kPushTool = {
    .id = "push",
    .name = "Push",
    .description = "The clay gives way to the hand",
    // a dent in a surface, and an arrow into it
    .icon = "M2 15 L6 15 C9 15 9 20 12 20 C15 20 15 15 18 15 L22 15 M12 3 L12 14 M8 10 L12 14 L16 10",
    .create = createPushTool,
};

ContactFinder::ContactFinder(Gpu& gpu, const ContactFrame& frame)
    : gpu_(gpu),
      frame_(frame),
      find_(gpu, "contact_find", contact_find_comp, {kContactWorkgroup}),
      check_(gpu, "contact_check", contact_check_comp, {gpu.reductionWorkgroup()}),
      push_(gpu, "contact_push", contact_push_comp, {kContactWorkgroup}),
      points_(gpu, frame.dataPointCount()) {}  // the first tracked frame fills all

void ContactFinder::recordCheck(Recorder& recorder, const Buffer<vec3>& data_points, bool first) {
  if (const std::size_t count = std::size_t(frame_.dataPointCount()) * imageCount(frame_.mirrors());
      first && points_.count() != count)
    points_ = Buffer<GpuContactPoint>(gpu_, count);

  ContactFindArgs find{};
  find.frame = frame_.state();
  find.data_points = data_points;
  find.points = points_;
  find.mirrors = frame_.mirrors();
  find.data_point_count = frame_.dataPointCount();
  find.first = first ? 1 : 0;
  find.hand = frame_.hand();
  recorder.dispatchIndirect(find_, find, frame_.groups(), ContactFrame::kFindGroups);

  ContactCheckArgs check{};
  check.points = points_;
  check.point_count = static_cast<std::uint32_t>(points_.count());
  check.decision = frame_.decision(kContactTargetDepth, kContactMaxRepeats);
  recorder.dispatchIndirect(check_, check, frame_.groups(), ContactFrame::kCheckGroups);
}

void ContactFinder::recordPush(Recorder& recorder) {
  ContactPushArgs push{};
  push.frame = frame_.state();
  push.points = points_;
  push.displacements = frame_.displacements();
  push.data_point_count = frame_.dataPointCount();
  push.mirrors = frame_.mirrors();
  recorder.dispatchIndirect(push_, push, frame_.groups(), ContactFrame::kPointGroups);
}

}  // namespace airclay
