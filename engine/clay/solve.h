// SPDX-License-Identifier: MIT
// Eq. (6)-(8): from moved data points to control points, by least squares.
//
// Both methods solve for displacements, p_new = p + A⁺ (d_new - d). The paper's eq. (7), Aᵀ(AAᵀ)⁻¹, exists
// only for independent rows that are fewer than the control points (Hsu et al. 1992, for touched points
// only); over all data points the pseudoinverse is (AᵀA)⁻¹Aᵀ.
#pragma once

#include <Eigen/Cholesky>
#include <filesystem>

#include "engine/clay/solve_method.h"
#include "engine/clay/subdivide.h"
#include "shaders/clay/solve_io.h"

namespace airclay {

/// A data point and its target position.
struct Move {
  int index = 0;               ///< row of A
  Vec3 target = Vec3::Zero();  ///< metres, world
};

/// Exact Moore-Penrose: singular values below this fraction of the largest are truncated.
inline constexpr double kSingularCutoff = 1e-7;

/// λ of the live `touched` solve, Aₛᵀ(AₛAₛᵀ + λ²I)⁻¹. Without it, ten adjacent points with 1 mm of noise move
/// the cage by a metre.
inline constexpr double kTouchedDamping = 0.1;

/// The new control points, metres, world: exact Moore-Penrose over the method's rows (damping = 0) or damped
/// least squares (damping > 0, kSolveTouched only). \throw Error if an index is out of range or occurs twice,
/// or an ill-conditioned problem has more than AllRowsSolver::kMaxControlPoints control points.
std::vector<Vec3> solveControlPoints(const StencilMatrix& matrix, const std::vector<Vec3>& control_points,
                                     const std::vector<Move>& moves, const SolveMethod* method,
                                     double damping = 0);

/// The `all` solve of one subdivision, factored once for repeated use:
/// displacement of control points = gram_inverse() * (Aᵀ * displacement of data points).
class AllRowsSolver {
 public:
  /// Rank-revealing, with kSingularCutoff. Dense in the control points. \throw Error above kMaxControlPoints.
  explicit AllRowsSolver(const StencilMatrix& matrix);
  /// (AᵀA)⁺, n x n, symmetric.
  const Eigen::MatrixXd& gramInverse() const { return gram_inverse_; }
  std::vector<Vec3> controlDisplacements(const StencilMatrix& matrix,
                                         const std::vector<Vec3>& data_displacements) const;

  static constexpr int kMaxControlPoints = 4096;  ///< a Gram inverse of 128 MB

 private:
  Eigen::MatrixXd gram_inverse_;
};

/// The damped `touched` solve for fixed rows, factored once for repeated use.
class TouchedRowsSolver {
 public:
  /// \pre `rows` are ascending, in range and unique; damping > 0. \throw Error if the smaller of the numbers
  /// of rows and of control points exceeds AllRowsSolver::kMaxControlPoints.
  TouchedRowsSolver(const StencilMatrix& matrix, const std::vector<int>& rows, double damping);
  const std::vector<int>& rows() const { return rows_; }
  /// The displacements of all control points, given those of rows() in the same order; metres.
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
  /// \throw Error like AllRowsSolver.
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

/// Reads `index,x,y,z` lines, metres, world. \throw Error naming file and line if an index is out of range or
/// occurs twice, or a value is not a finite number.
std::vector<Move> readMoves(const std::filesystem::path& file, int data_point_count);

}  // namespace airclay
