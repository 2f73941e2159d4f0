// SPDX-License-Identifier: MIT
#include "engine/sculpt/relax.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "shaders/sculpt/relax_check.comp.h"
#include "shaders/sculpt/relax_move.comp.h"
#include "shaders/sculpt/relax_umbrella.comp.h"

namespace airclay {

double relaxStrength(int levels, double frame_s) {
  const double roughest = 1 - std::cos(M_PI / std::exp2(levels));
  return (1 - std::exp(-std::max(frame_s, 0.0) / (kRelaxRepeats * kRelaxTime_s))) / (roughest * roughest);
}

SurfaceNeighbours surfaceNeighbours(const std::vector<std::array<int, 4>>& quads,
                                    std::size_t data_point_count) {
  struct Neighbours {
    std::vector<std::uint32_t> out, in;  ///< along edges that begin or end here
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
    // an inner edge is passed both ways, one of the border once: the border comes in by one and goes out by
    // another
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
                     std::uint32_t mirrors, double strength) {
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
  move.mirrors = mirrors;
  move.strength = static_cast<float>(strength);
  move.hand = frame_.hand();
  recorder.dispatchIndirect(move_, move, frame_.groups(), ContactFrame::kFindGroups);

  RelaxCheckArgs check{};
  check.displacements = frame_.displacements();
  check.data_point_count = frame_.dataPointCount();
  check.decision = frame_.decision(kRelaxLeast_m, kRelaxRepeats);
  recorder.dispatchIndirect(check_, check, frame_.groups(), ContactFrame::kCheckGroups);
}

}  // namespace airclay
