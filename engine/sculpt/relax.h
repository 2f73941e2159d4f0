// SPDX-License-Identifier: MIT
// The tool *smooth*: clay near the hand relaxes.
//
// The umbrella vector of a data point leads to the average of its neighbours. Moving along it smooths but
// also shrinks: on a ball, all umbrella vectors point inwards. So a point moves by its umbrella vector minus
// the average of its neighbours' (Kobbelt et al. 1998, "Interactive multi-resolution modeling on arbitrary
// meshes": the umbrella operator applied twice, which minimizes thin-plate instead of membrane energy). Only
// the components along each point's own normal are compared and used, so data points do not drift across the
// surface, and evenly curved clay keeps its shape even if it is coarse. On a border only the two neighbours
// along it count, and the component across it is used too: the border relaxes as a curve, and the adjacent
// surface does not pull it in.
//
// The cage cannot represent every shape. Its roughest one, with adjacent control points displaced in opposite
// directions, has the eigenvalue -μ under the umbrella operator on the grid of data points, μ = 1 - cos(π /
// 2^levels). The displacement is therefore divided by μ², so that clay relaxes equally fast at all levels.
// The roughest shape decays by 1 / e in kRelaxTime_s at any frame rate, in kRelaxRepeats steps per frame. A
// step never exceeds the whole displacement, so smoothing does not overshoot.
#pragma once

#include "engine/clay/subdivide.h"
#include "engine/sculpt/tool.h"
#include "shaders/sculpt/relax_io.h"

namespace airclay {

extern const Tool kSmoothTool;

/// Decay time of the roughest shape. Waves along one direction with four control points per period, such as
/// dents of a fingertip, have an eighth of its eigenvalue and take 64 times as long.
inline constexpr double kRelaxTime_s = 0.01;

/// The factor of the displacements in a step, for a cage subdivided `levels` times.
double relaxStrength(int levels, double frame_s);

/// The neighbours of each data point along the quads' edges; for a point on a border the two on the same
/// border, in order.
struct SurfaceNeighbours {
  std::vector<std::uint32_t> starts, entries;  ///< point i: entries[starts[i]] to entries[starts[i + 1] - 1]
  std::vector<std::uint32_t> borders;          ///< 1 for points on a border
};
SurfaceNeighbours surfaceNeighbours(const std::vector<std::array<int, 4>>& quads,
                                    std::size_t data_point_count);

/// Relaxes clay on the GPU.
class Relaxer {
 public:
  /// `frame` outlives it.
  Relaxer(Gpu& gpu, const ContactFrame& frame, const Subdivision& subdivision);

  /// Records the displacements for the solver, and a check of them. `normals`: of the data points at the
  /// start of the frame. `strength`: relaxStrength().
  void record(Recorder& recorder, const Buffer<vec3>& data_points, const Buffer<vec3>& normals,
              double strength, double reach_m = kRelaxReach_m);

 private:
  const ContactFrame& frame_;
  Kernel<RelaxUmbrellaArgs> umbrella_;
  Kernel<RelaxMoveArgs> move_;
  Kernel<RelaxCheckArgs> check_;
  Buffer<std::uint32_t> starts_, entries_, borders_;
  Buffer<vec3> umbrellas_;
};

/// The reference implementation of relax_umbrella and relax_move, in double precision: displacements of all
/// data points. `nearness`: 0 to 1, one per data point.
std::vector<Vec3> relaxReference(const SurfaceNeighbours& neighbours, const std::vector<Vec3>& data_points,
                                 const std::vector<Vec3>& normals, const std::vector<double>& nearness,
                                 double strength);
/// A data point's nearness to the hand or an image of it: 1 on the skin and inside, 0 beyond `reach_m`.
double relaxNearness(const DistanceGrid& hand, const ContactPose& now, std::uint32_t mirrors,
                     const Vec3& data_point, double reach_m = kRelaxReach_m);

}  // namespace airclay
