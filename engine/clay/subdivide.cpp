// SPDX-License-Identifier: MIT
#include "engine/clay/subdivide.h"

#include "engine/core/task.h"
#include "shaders/clay/normals.comp.h"
#include "shaders/clay/subdivide.comp.h"

namespace airclay {
namespace {

/// Lists of varying length: list i has the entries from starts[i] to starts[i + 1], exclusive.
struct Lists {
  std::vector<std::uint32_t> starts, entries;
};

/// For each data point, its adjoining quads.
Lists adjoiningQuads(const std::vector<std::array<int, 4>>& quads, std::size_t data_point_count) {
  Lists lists{std::vector<std::uint32_t>(data_point_count + 1), std::vector<std::uint32_t>(4 * quads.size())};
  for (const std::array<int, 4>& quad : quads)
    for (const int corner : quad) ++lists.starts[std::size_t(corner) + 1];
  for (std::size_t i = 0; i < data_point_count; ++i) lists.starts[i + 1] += lists.starts[i];
  std::vector<std::uint32_t> next = lists.starts;
  for (std::size_t q = 0; q < quads.size(); ++q)
    for (const int corner : quads[q])
      lists.entries[next[std::size_t(corner)]++] = static_cast<std::uint32_t>(q);
  return lists;
}

}  // namespace

SurfaceEvaluator::SurfaceEvaluator(Gpu& gpu, const Subdivision& subdivision)
    : subdivide_(gpu, "subdivide", subdivide_comp, {kSubdivideWorkgroup}),
      normals_kernel_(gpu, "normals", normals_comp, {kSubdivideWorkgroup}) {
  const StencilMatrix& matrix = subdivision.matrix;
  const auto data_point_count = static_cast<std::size_t>(matrix.rows());
  std::vector<std::uint32_t> row_starts{0}, columns;
  std::vector<float> weights;
  columns.reserve(static_cast<std::size_t>(matrix.nonZeros()));
  weights.reserve(static_cast<std::size_t>(matrix.nonZeros()));
  for (int row = 0; row < matrix.outerSize(); ++row) {
    reportProgress(std::size_t(row), data_point_count);
    for (StencilMatrix::InnerIterator entry(matrix, row); entry; ++entry) {
      columns.push_back(static_cast<std::uint32_t>(entry.col()));
      weights.push_back(static_cast<float>(entry.value()));
    }
    row_starts.push_back(static_cast<std::uint32_t>(columns.size()));
  }
  row_starts_ = Buffer<std::uint32_t>(gpu, row_starts);
  columns_ = Buffer<std::uint32_t>(gpu, columns);
  weights_ = Buffer<float>(gpu, weights);

  const Lists adjoining = adjoiningQuads(subdivision.quads, data_point_count);
  quad_starts_ = Buffer<std::uint32_t>(gpu, adjoining.starts);
  quads_at_ = Buffer<std::uint32_t>(gpu, adjoining.entries);
  std::vector<std::uint32_t> quads, triangles;
  quads.reserve(4 * subdivision.quads.size());
  triangles.reserve(6 * subdivision.quads.size());
  for (const std::array<int, 4>& quad : subdivision.quads) {
    for (const int corner : quad) quads.push_back(static_cast<std::uint32_t>(corner));
    for (const std::size_t corner : {0, 1, 2, 0, 2, 3})
      triangles.push_back(static_cast<std::uint32_t>(quad[corner]));
  }
  quads_ = Buffer<std::uint32_t>(gpu, quads);
  triangles_ = Buffer<std::uint32_t>(gpu, triangles);
  data_points_ = Buffer<vec3>(gpu, data_point_count);
  normals_ = Buffer<vec3>(gpu, data_point_count);
}

void SurfaceEvaluator::record(Recorder& recorder, const Buffer<vec3>& control_points) {
  recordPoints(recorder, control_points);
  recordNormals(recorder);
}

SubdivideArgs SurfaceEvaluator::subdivideArgs(const Buffer<vec3>& control_points) const {
  SubdivideArgs args{};
  args.control_points = control_points;
  args.row_starts = row_starts_;
  args.columns = columns_;
  args.weights = weights_;
  args.data_points = data_points_;
  args.data_point_count = dataPointCount();
  return args;
}

void SurfaceEvaluator::recordPoints(Recorder& recorder, const Buffer<vec3>& control_points) {
  const GroupRows groups = pointGroups();
  recorder.dispatch(subdivide_, subdivideArgs(control_points), groups.x, groups.y);
}

void SurfaceEvaluator::recordPointsIndirect(Recorder& recorder, const Buffer<vec3>& control_points,
                                            const RawBuffer& groups, std::uint64_t byte_offset) {
  recorder.dispatchIndirect(subdivide_, subdivideArgs(control_points), groups, byte_offset);
}

NormalsArgs SurfaceEvaluator::normalsArgs() const {
  NormalsArgs args{};
  args.data_points = data_points_;
  args.quad_starts = quad_starts_;
  args.quads_at = quads_at_;
  args.quads = quads_;
  args.normals = normals_;
  args.data_point_count = dataPointCount();
  return args;
}

void SurfaceEvaluator::recordNormals(Recorder& recorder) {
  const GroupRows groups = pointGroups();
  recorder.dispatch(normals_kernel_, normalsArgs(), groups.x, groups.y);
}

void SurfaceEvaluator::recordNormalsIndirect(Recorder& recorder, const RawBuffer& groups,
                                             std::uint64_t byte_offset) {
  recorder.dispatchIndirect(normals_kernel_, normalsArgs(), groups, byte_offset);
}

}  // namespace airclay
