// SPDX-License-Identifier: MIT
// Eq. (6)-(8): from moved data points back to control points, by least squares.
//
// Both forms solve displacements, p_new = p + A⁺ (d_new - d). The paper's eq. (7), Aᵀ(AAᵀ)⁻¹, exists only for
// fewer, independent rows than control points (Hsu et al. 1992, for the touched points alone); over all data
// points the pseudoinverse is (AᵀA)⁻¹Aᵀ.
#pragma once

#include <Eigen/Cholesky>
#include <filesystem>

#include "engine/clay/solve_method.h"
#include "engine/clay/subdivide.h"
#include "shaders/clay/solve_io.h"

namespace airclay {

/// A data point and its target.
struct Move {
  int index = 0;               ///< row of A
  Vec3 target = Vec3::Zero();  ///< metres, world
};

/// Exact Moore-Penrose: singular values below this share of the largest are cut.
inline constexpr double kSingularCutoff = 1e-7;

/// λ of the live `touched` solve, Aₛᵀ(AₛAₛᵀ + λ²I)⁻¹: ten neighbouring points with 1 mm of noise would
/// otherwise throw the cage by a metre.
inline constexpr double kTouchedDamping = 0.1;

/// New control points, exact Moore-Penrose over the chosen rows (damping = 0) or damped least squares
/// (damping > 0, kSolveTouched). Every moved row counts once: \pre indices are in range and different.
std::vector<Vec3> solveControlPoints(const StencilMatrix& matrix, const std::vector<Vec3>& control_points,
                                     const std::vector<Move>& moves, const SolveMethod* method,
                                     double damping = 0);

/// The repeated `all` solve of one subdivision: factored once, kept as long as the matrix holds.
/// displacement of control points = gram_inverse() * (Aᵀ * displacement of data points).
class AllRowsSolver {
 public:
  /// Rank-revealing, with kSingularCutoff. Dense in the control points: \throw Error past kMaxControlPoints.
  explicit AllRowsSolver(const StencilMatrix& matrix);
  /// (AᵀA)⁺, n x n, symmetric.
  const Eigen::MatrixXd& gramInverse() const { return gram_inverse_; }
  std::vector<Vec3> controlDisplacements(const StencilMatrix& matrix,
                                         const std::vector<Vec3>& data_displacements) const;

  static constexpr int kMaxControlPoints = 4096;  ///< 128 MB of gram inverse

 private:
  Eigen::MatrixXd gram_inverse_;
};

/// A `touched` solve of the same rows again and again, damped: factored once, kept as long as the rows are
/// the same.
class TouchedRowsSolver {
 public:
  /// \pre `rows` are ascending, in range and different; damping > 0. \throw Error when the smaller of rows
  /// and control points is past AllRowsSolver::kMaxControlPoints.
  TouchedRowsSolver(const StencilMatrix& matrix, const std::vector<int>& rows, double damping);
  const std::vector<int>& rows() const { return rows_; }
  /// Of all control points, from the displacements of rows(), in their order.
  std::vector<Vec3> controlDisplacements(const std::vector<Vec3>& row_displacements) const;

 private:
  int control_point_count_;
  std::vector<int> rows_, columns_;  ///< columns: the control points that the rows depend on, ascending
  StencilMatrix touched_;            ///< rows_ by columns_
  bool more_rows_;
  Eigen::LLT<Eigen::MatrixXd> factor_;  ///< of AₛᵀAₛ + λ²I or AₛAₛᵀ + λ²I, whichever is smaller
};

/// The `all` solve on the GPU, in double precision.
class ControlPointSolver final : public ClaySolver {
 public:
  /// \throw Error as AllRowsSolver.
  ControlPointSolver(Gpu& gpu, const StencilMatrix& matrix);

  /// recordIndirect() with the full number of workgroups.
  void record(Recorder& recorder, const Buffer<vec3>& displacements, const Buffer<double>& exact_points,
              const Buffer<vec3>& control_points);
  bool onDevice() const override { return true; }
  void recordIndirect(Recorder& recorder, const Buffer<vec3>& displacements,
                      const Buffer<double>& exact_points, const Buffer<vec3>& control_points,
                      const RawBuffer& groups, std::uint64_t project_offset,
                      std::uint64_t apply_offset) override;
  std::uint32_t projectGroups() const override { return control_point_count_; }
  std::uint32_t applyGroups() const override { return groupsFor(control_point_count_, kSolveWorkgroup); }

 private:
  SolveProjectArgs projectArgs(const Buffer<vec3>& displacements) const;
  SolveApplyArgs applyArgs(const Buffer<double>& exact_points, const Buffer<vec3>& control_points) const;

  std::uint32_t control_point_count_;
  Kernel<SolveProjectArgs> project_;
  Kernel<SolveApplyArgs> apply_;
  Buffer<std::uint32_t> column_starts_, rows_;
  Buffer<float> weights_;
  Buffer<double> gram_inverse_, projected_;
};

/// Reads `index,x,y,z` lines. \throw Error naming file, line and the range of indices: an index that does not
/// exist, one given twice, a value that is no finite number.
std::vector<Move> readMoves(const std::filesystem::path& file, int data_point_count);

}  // namespace airclay
