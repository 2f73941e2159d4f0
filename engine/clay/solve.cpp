// SPDX-License-Identifier: MIT
#include "engine/clay/solve.h"

#include "shaders/clay/solve_apply.comp.h"
#include "shaders/clay/solve_project.comp.h"

namespace airclay {
namespace {

std::unique_ptr<ClaySolver> createAllSolver(Gpu& gpu, const StencilMatrix& matrix) {
  return std::make_unique<ControlPointSolver>(gpu, matrix);
}

}  // namespace

const SolveMethod kSolveAll = {
    .id = "all",
    .name = "All points",
    .description = "fits all data points; those that the hand did not move keep their positions",
    .fits_unmoved = true,
    .max_control_points = AllRowsSolver::kMaxControlPoints,
    .create = createAllSolver,
};

ControlPointSolver::ControlPointSolver(Gpu& gpu, const StencilMatrix& matrix)
    : control_point_count_(static_cast<std::uint32_t>(matrix.cols())),
      project_(gpu, "solve_project", solve_project_comp,
               {gpu.isCpu() ? gpu.subgroupSize() : kSolveWorkgroup}),
      apply_(gpu, "solve_apply", solve_apply_comp, {kSolveWorkgroup}) {
  const Eigen::MatrixXd gram_inverse = AllRowsSolver(matrix).gramInverse();
  gram_inverse_ = Buffer<double>(
      gpu, std::span<const double>(gram_inverse.data(), static_cast<std::size_t>(gram_inverse.size())));
  const StencilMatrix transposed = matrix.transpose();
  std::vector<std::uint32_t> column_starts{0}, rows;
  std::vector<float> weights;
  for (int column = 0; column < transposed.outerSize(); ++column) {
    for (StencilMatrix::InnerIterator entry(transposed, column); entry; ++entry) {
      rows.push_back(static_cast<std::uint32_t>(entry.col()));
      weights.push_back(static_cast<float>(entry.value()));
    }
    column_starts.push_back(static_cast<std::uint32_t>(rows.size()));
  }
  column_starts_ = Buffer<std::uint32_t>(gpu, column_starts);
  rows_ = Buffer<std::uint32_t>(gpu, rows);
  weights_ = Buffer<float>(gpu, weights);
  projected_ = Buffer<double>(gpu, 3 * std::size_t(control_point_count_));
}

SolveProjectArgs ControlPointSolver::projectArgs(const Buffer<vec3>& displacements) const {
  SolveProjectArgs args{};
  args.displacements = displacements;
  args.column_starts = column_starts_;
  args.rows = rows_;
  args.weights = weights_;
  args.projected = projected_;
  return args;
}

SolveApplyArgs ControlPointSolver::applyArgs(const Buffer<double>& exact_points,
                                             const Buffer<vec3>& control_points) const {
  SolveApplyArgs args{};
  args.projected = projected_;
  args.gram_inverse = gram_inverse_;
  args.exact_points = exact_points;
  args.control_points = control_points;
  args.control_point_count = control_point_count_;
  return args;
}

void ControlPointSolver::record(Recorder& recorder, const Buffer<vec3>& displacements,
                                const Buffer<double>& exact_points, const Buffer<vec3>& control_points) {
  recorder.dispatch(project_, projectArgs(displacements), projectGroups());
  recorder.dispatch(apply_, applyArgs(exact_points, control_points), applyGroups());
}

void ControlPointSolver::recordIndirect(Recorder& recorder, const Buffer<vec3>& displacements,
                                        const Buffer<double>& exact_points,
                                        const Buffer<vec3>& control_points, const RawBuffer& groups,
                                        std::uint64_t project_offset, std::uint64_t apply_offset) {
  recorder.dispatchIndirect(project_, projectArgs(displacements), groups, project_offset);
  recorder.dispatchIndirect(apply_, applyArgs(exact_points, control_points), groups, apply_offset);
}

}  // namespace airclay
