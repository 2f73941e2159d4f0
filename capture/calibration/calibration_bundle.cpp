// SPDX-License-Identifier: MIT
// Bundle adjustment (Triggs et al. 2000, "Bundle Adjustment - A Modern Synthesis") of lenses, cameras and
// boards, with Ceres.
#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/calibration/calibration_parts.h"
#include "engine/core/error.h"
#include "engine/core/median.h"
#include "engine/core/task.h"

namespace airclay {
namespace {

constexpr double kNotProjected_px = 1e6;
// The smallest plausible depth of a board's corner.
constexpr double kMinDepth_m = 1e-3;
// No corner is more accurate than this; keeps weights finite for views without noise.
constexpr double kMinNoise_px = 0.01;

constexpr int kLensSize = 12;  // fx fy cx cy, then Lens::distortion
constexpr int kPoseSize = 6;   // the rotation's vector, the translation
using LensBlock = std::array<double, kLensSize>;
using PoseBlock = std::array<double, kPoseSize>;

LensBlock blockOf(const Lens& lens) {
  LensBlock block{lens.fx, lens.fy, lens.cx, lens.cy};
  std::copy(lens.distortion.begin(), lens.distortion.end(), block.begin() + 4);
  return block;
}

PoseBlock blockOf(const Pose& pose) {
  const Eigen::AngleAxisd turn(pose.linear());
  const Vec3 w = turn.angle() * turn.axis(), t = pose.translation();
  return {w.x(), w.y(), w.z(), t.x(), t.y(), t.z()};
}

Lens lensOf(const LensBlock& block, LensModel model) {
  Lens lens;
  lens.model = model;
  lens.fx = block[0], lens.fy = block[1], lens.cx = block[2], lens.cy = block[3];
  std::copy(block.begin() + 4, block.end(), lens.distortion.begin());
  return lens;
}

Pose poseOf(const PoseBlock& block) {
  Pose pose = Pose::Identity();
  pose.linear() = rotationFromVector({block[0], block[1], block[2]});
  pose.translation() = Vec3(block[3], block[4], block[5]);
  return pose;
}

/// The two lens models of engine/camera/lens.cpp (OpenCV's manual, calib3d), for Ceres' automatic
/// differentiation.
template <class T>
void distortPerspective(const T* k, T& x, T& y) {
  const T r2 = x * x + y * y;
  const T scale =
      (1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))) / (1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])));
  const T distorted_x = x * scale + 2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x);
  y = y * scale + k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y;
  x = distorted_x;
}

template <class T>
void distortFisheye(const T* k, T& x, T& y) {
  const T r2 = x * x + y * y;
  if (r2 < 1e-16) return;
  const T r = sqrt(r2), angle = atan(r), s = angle * angle;
  const T scale = angle * (1.0 + s * (k[0] + s * (k[1] + s * (k[2] + s * k[3])))) / r;
  x *= scale;
  y *= scale;
}

struct Reprojection {
  LensModel model;
  Vec3 corner;  // board
  Vec2 pixel;
  double noise_px;

  template <class T>
  bool operator()(const T* lens, const T* camera, const T* stand, T* residual) const {
    const T in_board[3] = {T(corner.x()), T(corner.y()), T(corner.z())};
    T in_world[3], in_camera[3];
    ceres::AngleAxisRotatePoint(stand, in_board, in_world);
    for (int i = 0; i < 3; ++i) in_world[i] += stand[3 + i];
    ceres::AngleAxisRotatePoint(camera, in_world, in_camera);
    for (int i = 0; i < 3; ++i) in_camera[i] += camera[3 + i];
    if (in_camera[2] < kMinDepth_m) return false;
    T x = in_camera[0] / in_camera[2], y = in_camera[1] / in_camera[2];
    if (model == LensModel::kFisheye)
      distortFisheye(lens + 4, x, y);
    else
      distortPerspective(lens + 4, x, y);
    residual[0] = (pixel.x() - lens[2] - lens[0] * x) / noise_px;
    residual[1] = (pixel.y() - lens[3] - lens[1] * y) / noise_px;
    return true;
  }
};

// A radial term moves the image's corner by at most about half of its radius, a tangential one by a
// twentieth. This prior is much weaker than the evidence of the views, but limits coefficients that the views
// do not determine, which would otherwise grow to hundreds with opposite signs.
constexpr double kUsualRadial = 0.5, kUsualTangential = 0.05;

/// The prior of a lens: its coefficients relative to their usual size.
struct LensPrior {
  std::array<double, 8> per_usual{};

  explicit LensPrior(const BundleCamera& camera) {
    const double corner = camera.half_diagonal_px / camera.lens.fx, s = corner * corner;
    const bool is_fisheye = camera.lens.model == LensModel::kFisheye;
    const std::array<double, 8> terms =
        is_fisheye ? std::array<double, 8>{s, s * s, s * s * s, s * s * s * s}
                   : std::array<double, 8>{s, s * s, 0, 0, s * s * s, s, s * s, s * s * s};
    for (std::size_t i = 0; i < 8; ++i) per_usual[i] = camera.free[i] ? terms[i] / kUsualRadial : 0;
    if (!is_fisheye && camera.free[2]) per_usual[2] = per_usual[3] = corner / kUsualTangential;
  }

  template <class T>
  bool operator()(const T* lens, T* residual) const {
    for (std::size_t i = 0; i < 8; ++i) residual[i] = per_usual[i] * lens[4 + i];
    return true;
  }
};

/// Silences Ceres' messages about rejected steps on standard error; the summary has the result.
void quietCeres() {
  FLAGS_minloglevel = google::GLOG_FATAL;
}

/// The bundle as Ceres' parameter blocks.
struct Blocks {
  std::vector<LensBlock> lenses;
  std::vector<PoseBlock> cameras, stands;
  ceres::Problem problem;

  Blocks(const Bundle& bundle, const AdjustOptions& options) {
    quietCeres();
    for (const BundleCamera& camera : bundle.cameras) {
      lenses.push_back(blockOf(camera.lens));
      cameras.push_back(blockOf(camera.camera_from_world));
    }
    for (const Pose& pose : bundle.world_from_board) stands.push_back(blockOf(pose));
    for (const BundleView& view : bundle.views) addView(bundle, view, options);
    for (std::size_t i = 0; i < bundle.cameras.size(); ++i)
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<LensPrior, 8, kLensSize>(new LensPrior(bundle.cameras[i])), nullptr,
          lenses[i].data());
    for (std::size_t i = 0; i < bundle.cameras.size(); ++i) holdParts(bundle.cameras[i], i, options);
    const std::size_t held = options.fix_cameras ? cameras.size() : options.fix_stands ? 0 : 1;
    for (std::size_t i = 0; i < held; ++i) hold(cameras[i]);
    if (options.fix_stands)
      for (PoseBlock& stand : stands) hold(stand);
  }

 private:
  void hold(PoseBlock& block) {
    if (problem.HasParameterBlock(block.data())) problem.SetParameterBlockConstant(block.data());
  }

  void addView(const Bundle& bundle, const BundleView& view, const AdjustOptions& options) {
    const auto c = static_cast<std::size_t>(view.camera), s = static_cast<std::size_t>(view.stand);
    const BundleCamera& camera = bundle.cameras[c];
    for (std::size_t i = 0; i < view.corners.size(); ++i) {
      if (!view.trusted[i]) continue;
      ceres::LossFunction* loss = nullptr;
      if (options.loss == Loss::kCauchy)
        loss = new ceres::CauchyLoss(options.loss_scale);
      else
        loss = new ceres::HuberLoss(options.loss_scale);
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<Reprojection, 2, kLensSize, kPoseSize, kPoseSize>(
              new Reprojection{camera.lens.model, view.corners[i], view.pixels[i], camera.noise_px}),
          loss, lenses[c].data(), cameras[c].data(), stands[s].data());
    }
  }

  void holdParts(const BundleCamera& camera, std::size_t place, const AdjustOptions& options) {
    std::vector<int> held;
    if (!camera.free_center) held = {2, 3};
    for (int i = 0; i < 8; ++i)
      if (!camera.free[static_cast<std::size_t>(i)]) held.push_back(4 + i);
    if (options.fix_lenses)
      problem.SetParameterBlockConstant(lenses[place].data());
    else if (!held.empty())
      problem.SetManifold(lenses[place].data(), new ceres::SubsetManifold(kLensSize, held));
  }
};

ceres::Solver::Options solverOptions(Blocks& blocks, const AdjustOptions& options) {
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.num_threads = 2;
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = 1e-9;
  solver.logging_type = ceres::SILENT;
  // Boards are independent of each other, so they are eliminated first (Schur complement).
  auto* order = new ceres::ParameterBlockOrdering;
  for (PoseBlock& stand : blocks.stands)
    if (blocks.problem.HasParameterBlock(stand.data())) order->AddElementToGroup(stand.data(), 0);
  for (std::size_t i = 0; i < blocks.lenses.size(); ++i)
    for (double* block : {blocks.lenses[i].data(), blocks.cameras[i].data()})
      if (blocks.problem.HasParameterBlock(block)) order->AddElementToGroup(block, 1);
  solver.linear_solver_ordering.reset(order);
  return solver;
}

/// Reports progress between Ceres' iterations and aborts the solver if the task was cancelled.
class CancellationCheck : public ceres::IterationCallback {
 public:
  explicit CancellationCheck(double done) : done_(done) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    try {
      reportProgress(done_);
    } catch (...) {
      cancelled = std::current_exception();
      return ceres::SOLVER_ABORT;
    }
    return ceres::SOLVER_CONTINUE;
  }

  std::exception_ptr cancelled;

 private:
  double done_;
};

}  // namespace

int BundleView::trustedCount() const {
  return static_cast<int>(std::count(trusted.begin(), trusted.end(), char{1}));
}

void adjust(Bundle& bundle, const AdjustOptions& options) {
  Blocks blocks(bundle, options);
  ceres::Solver::Options solver = solverOptions(blocks, options);
  CancellationCheck cancellation(options.done);
  solver.callbacks = {&cancellation};
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &blocks.problem, &summary);
  if (cancellation.cancelled) std::rethrow_exception(cancellation.cancelled);
  if (!summary.IsSolutionUsable())
    throw Error("the bundle adjustment diverges; expected views of a flat board, tilted to all sides");

  for (std::size_t i = 0; i < bundle.cameras.size(); ++i) {
    BundleCamera& camera = bundle.cameras[i];
    camera.lens = withMonotonicRange(lensOf(blocks.lenses[i], camera.lens.model));
    camera.camera_from_world = poseOf(blocks.cameras[i]);
  }
  for (std::size_t i = 0; i < bundle.world_from_board.size(); ++i)
    bundle.world_from_board[i] = poseOf(blocks.stands[i]);
}

Vec2 residualOf(const Bundle& bundle, const BundleView& view, std::size_t corner) {
  const BundleCamera& camera = bundle.cameras[static_cast<std::size_t>(view.camera)];
  const Pose& world_from_board = bundle.world_from_board[static_cast<std::size_t>(view.stand)];
  const std::optional<Vec2> projected =
      projectThroughLens(camera.lens, camera.camera_from_world * (world_from_board * view.corners[corner]));
  return projected ? Vec2(view.pixels[corner] - *projected) : Vec2(kNotProjected_px, kNotProjected_px);
}

std::vector<double> residualLengths(const Bundle& bundle, const BundleView& view) {
  std::vector<double> lengths;
  for (std::size_t i = 0; i < view.corners.size(); ++i) lengths.push_back(residualOf(bundle, view, i).norm());
  return lengths;
}

double robustNoise(const Bundle& bundle, int camera) {
  std::vector<double> lengths;
  for (const BundleView& view : bundle.views)
    if (view.camera == camera)
      for (std::size_t i = 0; i < view.corners.size(); ++i)
        if (view.trusted[i]) lengths.push_back(residualOf(bundle, view, i).norm());
  if (lengths.empty()) return 1;
  // The length of a vector with two coordinates of deviation 1 has the median sqrt(2 ln 2) (Rayleigh
  // distribution).
  return std::max(median(std::move(lengths)) / std::sqrt(2 * std::log(2.0)), kMinNoise_px);
}

double robustCost(const Bundle& bundle, double noise_px) {
  const ceres::CauchyLoss loss(AdjustOptions{}.loss_scale);
  double cost = 0, rho[3];
  for (const BundleView& view : bundle.views)
    for (std::size_t i = 0; i < view.corners.size(); ++i) {
      if (!view.trusted[i]) continue;
      loss.Evaluate(residualOf(bundle, view, i).squaredNorm() / (noise_px * noise_px), rho);
      cost += rho[0];
    }
  return cost;
}

std::vector<double> focalSigmas(const Bundle& bundle) {
  Blocks blocks(bundle, {});
  std::vector<double> sigmas(bundle.cameras.size(), std::numeric_limits<double>::infinity());
  ceres::Covariance::Options options;
  options.num_threads = 2;
  ceres::Covariance covariance(options);
  std::vector<std::pair<const double*, const double*>> blocks_to_compute;
  for (const LensBlock& lens : blocks.lenses) blocks_to_compute.emplace_back(lens.data(), lens.data());
  if (!covariance.Compute(blocks_to_compute, &blocks.problem)) return sigmas;  // rank-deficient
  for (std::size_t i = 0; i < sigmas.size(); ++i) {
    const double* lens = blocks.lenses[i].data();
    double values[kLensSize * kLensSize];
    if (covariance.GetCovarianceBlock(lens, lens, values))
      sigmas[i] = std::sqrt(values[0]) / blocks.lenses[i][0];
  }
  return sigmas;
}

std::vector<PoseSigma> poseSigmas(const Bundle& bundle) {
  AdjustOptions known;
  known.fix_lenses = known.fix_stands = true;
  Blocks blocks(bundle, known);
  ceres::Covariance::Options options;
  options.num_threads = 2;
  ceres::Covariance covariance(options);
  std::vector<PoseSigma> sigmas(bundle.cameras.size());
  std::vector<std::pair<const double*, const double*>> blocks_to_compute;
  for (const PoseBlock& pose : blocks.cameras) blocks_to_compute.emplace_back(pose.data(), pose.data());
  if (!covariance.Compute(blocks_to_compute, &blocks.problem)) return sigmas;
  for (std::size_t i = 0; i < sigmas.size(); ++i) {
    Eigen::Matrix<double, kPoseSize, kPoseSize, Eigen::RowMajor> values;
    covariance.GetCovarianceBlock(blocks_to_compute[i].first, blocks_to_compute[i].second, values.data());
    sigmas[i].turn = std::sqrt(values.topLeftCorner<3, 3>().trace());
    sigmas[i].place_m = std::sqrt(values.bottomRightCorner<3, 3>().trace());
  }
  return sigmas;
}

double trustedRadius(double noise_px) {
  // Three of a thousand good corners are beyond 3.4 deviations (Rayleigh); a third of a pixel is never an
  // outlier.
  return std::max(4 * noise_px, 0.35);
}

void trustNearCorners(Bundle& bundle) {
  for (BundleView& view : bundle.views) {
    const double radius = trustedRadius(bundle.cameras[static_cast<std::size_t>(view.camera)].noise_px);
    const std::vector<double> lengths = residualLengths(bundle, view);
    for (std::size_t i = 0; i < lengths.size(); ++i) view.trusted[i] = lengths[i] <= radius;
    // A view with fewer than half of its corners trusted is rejected.
    if (2 * view.trustedCount() < static_cast<int>(lengths.size()) || view.trustedCount() < 4)
      std::fill(view.trusted.begin(), view.trusted.end(), char{0});
  }
}

}  // namespace airclay
