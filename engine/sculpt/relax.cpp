// SPDX-License-Identifier: MIT
#include "engine/sculpt/relax.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "engine/clay/clay.h"
#include "shaders/sculpt/relax_check.comp.h"
#include "shaders/sculpt/relax_move.comp.h"
#include "shaders/sculpt/relax_umbrella.comp.h"

namespace airclay {
namespace {

constexpr ToolSetting kSettings[] = {
    {.id = "reach", .name = "Reach", .unit = "mm", .minimum = 2, .maximum = 40, .initial = 10},
    {.id = "strength", .name = "Strength", .unit = "", .minimum = 0.1, .maximum = 4, .initial = 1}};

class SmoothTool final : public ToolInstance {
 public:
  explicit SmoothTool(const ToolContext& context)
      : frame_(context.frame),
        clay_(context.clay),
        relaxer_(context.gpu, context.frame, context.clay.subdivision()) {}

  std::uint32_t maxRepeats() const override { return kRelaxRepeats; }
  void recordCheck(Recorder& recorder, const ToolChoice& choice, double frame_s, bool) override {
    const double reach_mm = choice.values()[0], strength = choice.values()[1];
    relaxer_.record(recorder, clay_.dataPoints(), clay_.normals(),
                    relaxStrength(clay_.levels(), strength * frame_s), 1e-3 * reach_mm);
  }
  std::vector<Vec3> displacementsOnHost(std::vector<int>& rows) const override {
    std::vector<Vec3> displacements;
    const std::vector<vec3> all = frame_.displacements().download();
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (all[i] == vec3::Zero()) continue;
      rows.push_back(static_cast<int>(i));
      displacements.emplace_back(all[i].cast<double>());
    }
    return displacements;
  }
  /// Smoothing has no target.
  double remainingMetres() const override { return 0; }

 private:
  const ContactFrame& frame_;
  const Clay& clay_;
  Relaxer relaxer_;
};

std::unique_ptr<ToolInstance> createSmoothTool(const ToolContext& context) {
  return std::make_unique<SmoothTool>(context);
}

}  // namespace

const Tool kSmoothTool = {
    .id = "smooth",
    .name = "Smooth",
    .description = "Clay near the hand relaxes",
    // a rough line above a smooth one
    .icon = "M2 9 L5 5 L8 10 L11 4 L14 10 L17 5 L20 9 L22 7 M2 19 C7 14 17 14 22 19",
    .settings = kSettings,
    .create = createSmoothTool,
};

double relaxStrength(int levels, double frame_s) {
  const double roughest = 1 - std::cos(M_PI / std::exp2(levels));
  return (1 - std::exp(-std::max(frame_s, 0.0) / (kRelaxRepeats * kRelaxTime_s))) / (roughest * roughest);
}

SurfaceNeighbours surfaceNeighbours(const std::vector<std::array<int, 4>>& quads,
                                    std::size_t data_point_count) {
  struct Neighbours {
    std::vector<std::uint32_t> out, in;  ///< along edges that start or end here
  };
  std::vector<Neighbours> of(data_point_count);
  for (const std::array<int, 4>& quad : quads)
    for (std::size_t k = 0; k < 4; ++k) {
      const auto from = std::size_t(quad[k]), to = std::size_t(quad[(k + 1) % 4]);
      of[from].out.push_back(static_cast<std::uint32_t>(to));
      of[to].in.push_back(static_cast<std::uint32_t>(from));
    }
  SurfaceNeighbours neighbours{{0}, {}, {}};
  for (Neighbours& point : of) {
    std::sort(point.out.begin(), point.out.end());
    std::sort(point.in.begin(), point.in.end());
    // inner edges occur in both directions, border edges in one: a border point has one incoming and one
    // outgoing
    std::vector<std::uint32_t> along;
    std::set_difference(point.in.begin(), point.in.end(), point.out.begin(), point.out.end(),
                        std::back_inserter(along));
    std::set_difference(point.out.begin(), point.out.end(), point.in.begin(), point.in.end(),
                        std::back_inserter(along));
    const bool border = !along.empty();
    const std::vector<std::uint32_t>& entries = border ? along : point.out;
    neighbours.entries.insert(neighbours.entries.end(), entries.begin(), entries.end());
    neighbours.starts.push_back(static_cast<std::uint32_t>(neighbours.entries.size()));
    neighbours.borders.push_back(border ? 1 : 0);
  }
  return neighbours;
}

Relaxer::Relaxer(Gpu& gpu, const ContactFrame& frame, const Subdivision& subdivision)
    : frame_(frame),
      umbrella_(gpu, "relax_umbrella", relax_umbrella_comp, {kContactWorkgroup}),
      move_(gpu, "relax_move", relax_move_comp, {kContactWorkgroup}),
      check_(gpu, "relax_check", relax_check_comp, {gpu.reductionWorkgroup()}),
      umbrellas_(gpu, frame.dataPointCount()) {
  const SurfaceNeighbours neighbours = surfaceNeighbours(subdivision.quads, frame.dataPointCount());
  starts_ = Buffer<std::uint32_t>(gpu, neighbours.starts);
  entries_ = Buffer<std::uint32_t>(gpu, neighbours.entries);
  borders_ = Buffer<std::uint32_t>(gpu, neighbours.borders);
}

void Relaxer::record(Recorder& recorder, const Buffer<vec3>& data_points, const Buffer<vec3>& normals,
                     double strength, double reach_m) {
  RelaxUmbrellaArgs umbrella{};
  umbrella.data_points = data_points;
  umbrella.normals = normals;
  umbrella.starts = starts_;
  umbrella.neighbours = entries_;
  umbrella.borders = borders_;
  umbrella.umbrellas = umbrellas_;
  umbrella.data_point_count = frame_.dataPointCount();
  recorder.dispatchIndirect(umbrella_, umbrella, frame_.groups(), ContactFrame::kFindGroups);

  RelaxMoveArgs move{};
  move.frame = frame_.state();
  move.data_points = data_points;
  move.normals = normals;
  move.umbrellas = umbrellas_;
  move.starts = starts_;
  move.neighbours = entries_;
  move.borders = borders_;
  move.displacements = frame_.displacements();
  move.data_point_count = frame_.dataPointCount();
  move.mirrors = frame_.mirrors();
  move.strength = static_cast<float>(strength);
  move.reach_m = static_cast<float>(reach_m);
  move.hand = frame_.hand();
  recorder.dispatchIndirect(move_, move, frame_.groups(), ContactFrame::kFindGroups);

  RelaxCheckArgs check{};
  check.displacements = frame_.displacements();
  check.data_point_count = frame_.dataPointCount();
  check.decision = frame_.decision(kRelaxMinStep_m, kRelaxRepeats);
  recorder.dispatchIndirect(check_, check, frame_.groups(), ContactFrame::kCheckGroups);
}

}  // namespace airclay
