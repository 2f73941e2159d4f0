// SPDX-License-Identifier: MIT
// Estimates one camera's lens from its own views: the focal length by search, then as many distortion
// coefficients as the views support.
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "capture/calibration/calibration_parts.h"
#include "engine/core/error.h"
#include "engine/core/task.h"

namespace airclay {
namespace {

// A flat board's pose needs 4 corners; 6 leave redundancy to check it.
constexpr int kFewestCorners = 6;
// Limits the influence of a wrong view on a score.
constexpr double kWorst_px = 20;
// Beyond 75° from the axis, the pinhole model of the initial poses stretches pixels sevenfold.
const double kMaxSlope = std::tan(75 * M_PI / 180);

/// A lens model in the sequence from few coefficients to many.
struct Rung {
  LensModel model;
  FreeCoefficients free;
  int coefficients;
};

constexpr LensModel kPlain = LensModel::kPerspective, kFish = LensModel::kFisheye;
// Two radial, then the tangential, then the third radial coefficient: each has about a tenth of the previous
// one's effect in common lenses.
const std::vector<Rung> kPlainRungs = {{kPlain, {1}, 1},
                                       {kPlain, {1, 1}, 2},
                                       {kPlain, {1, 1, 1, 1}, 4},
                                       {kPlain, {1, 1, 1, 1, 1}, 5},
                                       {kPlain, {1, 1, 1, 1, 1, 1, 1, 1}, 8}};
const std::vector<Rung> kFishRungs = {{kFish, {1}, 1}, {kFish, {1, 1}, 2}, {kFish, {1, 1, 1, 1}, 4}};

Lens startLens(LensModel model, double focal_px, const CameraViews& camera) {
  Lens lens;
  lens.model = model;
  lens.fx = lens.fy = focal_px;
  lens.cx = 0.5 * (camera.width - 1), lens.cy = 0.5 * (camera.height - 1);
  return withMonotonicRange(lens);
}

double rmsOfView(const Lens& lens, const BundleView& view, const Pose& camera_from_board) {
  double sum = 0;
  for (std::size_t i = 0; i < view.corners.size(); ++i) {
    const std::optional<Vec2> projected = projectThroughLens(lens, camera_from_board * view.corners[i]);
    sum += projected ? std::min((*projected - view.pixels[i]).squaredNorm(), kWorst_px * kWorst_px)
                     : kWorst_px * kWorst_px;
  }
  return std::sqrt(sum / static_cast<double>(view.corners.size()));
}

/// The mean RMS error, pixels, of flat boards fitted to the views through this lens.
double misfit(const Lens& lens, const std::vector<BundleView>& views) {
  double sum = 0;
  for (const BundleView& view : views) {
    const std::vector<Pose> poses = boardPoses(lens, view);
    sum += poses.empty() ? kWorst_px : rmsOfView(lens, view, poses[0]);
  }
  return sum / static_cast<double>(views.size());
}

/// The focal length, without distortion, that best fits the views: an exhaustive search over the range of
/// real lenses, which is robust against outliers and unusual views.
Lens searchFocal(LensModel model, const LensTask& task) {
  constexpr double kStep = 1.12;
  const double widest = model == kFish ? 0.15 : 0.3, longest = model == kFish ? 1.5 : 6;
  Lens best;
  double best_misfit = std::numeric_limits<double>::infinity();
  for (double per_width = widest; per_width <= longest; per_width *= kStep) {
    reportProgress(task.done);
    const Lens lens = startLens(model, per_width * task.camera.width, task.camera);
    const double score = misfit(lens, task.views);
    if (score < best_misfit) best = lens, best_misfit = score;
  }
  return best;
}

Bundle startBundle(const Lens& lens, const LensTask& task) {
  Bundle bundle;
  bundle.cameras.push_back({lens});
  bundle.cameras[0].half_diagonal_px = 0.5 * std::hypot(task.camera.width, task.camera.height);
  for (const BundleView& view : task.views) {
    const std::vector<Pose> poses = boardPoses(lens, view);
    if (poses.empty()) continue;
    bundle.views.push_back(view);
    bundle.views.back().camera = 0;
    bundle.views.back().stand = static_cast<int>(bundle.world_from_board.size());
    bundle.world_from_board.push_back(poses[0]);
  }
  return bundle;
}

/// Adjusts twice: with a loss as wide as the unmodelled error, then as wide as the noise.
void fitRung(Bundle& bundle, const Rung& rung, double done) {
  AdjustOptions options;
  options.done = done;
  BundleCamera& camera = bundle.cameras[0];
  camera.free = rung.free;
  for (int round = 0; round < 2; ++round) {
    camera.noise_px = robustNoise(bundle, 0);
    adjust(bundle, options);
  }
  camera.noise_px = robustNoise(bundle, 0);
}

/// A rung's adjusted bundle.
struct Candidate {
  Rung rung;
  Bundle bundle;
};

std::vector<Candidate> fitAllRungs(const std::vector<Rung>& rungs, const LensTask& task) {
  Bundle bundle = startBundle(searchFocal(rungs[0].model, task), task);
  if (static_cast<int>(bundle.views.size()) < kFewestViews) return {};
  bundle.cameras[0].free_center = false;  // undetermined if there are only few, upright views
  fitRung(bundle, rungs[0], task.done);
  // With the better lens, poses that were the wrong one of two are now corrected.
  bundle = startBundle(bundle.cameras[0].lens, task);
  std::vector<Candidate> candidates;
  for (const Rung& rung : rungs) {
    fitRung(bundle, rung, task.done);
    candidates.push_back({rung, bundle});
  }
  return candidates;
}

/// Schwarz 1978 ("Estimating the dimension of a model"): -2 ln(likelihood) + parameters ln(observations).
double informationCriterion(const Candidate& candidate, double noise_px) {
  double observations = 0;
  for (const BundleView& view : candidate.bundle.views) observations += 2 * view.trustedCount();
  return robustCost(candidate.bundle, noise_px) + candidate.rung.coefficients * std::log(observations);
}

const Candidate& selectModel(const std::vector<Candidate>& candidates, const CameraViews& camera) {
  double noise_px = std::numeric_limits<double>::infinity();
  for (const Candidate& candidate : candidates)
    noise_px = std::min(noise_px, candidate.bundle.cameras[0].noise_px);
  const Candidate* best = &candidates.front();
  double least = std::numeric_limits<double>::infinity();
  for (const Candidate& candidate : candidates) {
    if (!reachesCorners(candidate.bundle.cameras[0].lens, camera.width, camera.height)) continue;
    const double criterion = informationCriterion(candidate, noise_px);
    // k4 to k6 are correlated with k1 to k3, so they must improve the fit by much more than their number.
    const double margin = candidate.rung.coefficients == 8 ? 30 : 0;
    if (criterion + margin < least) best = &candidate, least = criterion + margin;
  }
  return *best;
}

/// Prefers a perspective lens if it fits nearly as well, because all programs read it.
Candidate selectLens(const LensTask& task) {
  const std::vector<Candidate> plain = fitAllRungs(kPlainRungs, task), fish = fitAllRungs(kFishRungs, task);
  if (plain.empty() && fish.empty()) return {};
  if (plain.empty()) return selectModel(fish, task.camera);
  const Candidate best = selectModel(plain, task.camera);
  if (fish.empty()) return best;
  const Candidate best_fish = selectModel(fish, task.camera);
  const BundleCamera &as_plain = best.bundle.cameras[0], &as_fish = best_fish.bundle.cameras[0];
  const int width = task.camera.width, height = task.camera.height;
  const bool only_fish_reaches =
      !reachesCorners(as_plain.lens, width, height) && reachesCorners(as_fish.lens, width, height);
  const bool is_fish = best_fish.bundle.views.size() >= best.bundle.views.size() &&
                       (only_fish_reaches || as_fish.noise_px < 0.8 * as_plain.noise_px);
  return is_fish ? best_fish : best;
}

Candidate requestedLens(const LensTask& task, LensChoice choice) {
  const std::vector<Candidate> all =
      fitAllRungs(choice == LensChoice::kFisheye ? kFishRungs : kPlainRungs, task);
  const int coefficients = choice == LensChoice::kFive ? 5 : choice == LensChoice::kEight ? 8 : 4;
  for (const Candidate& candidate : all)
    if (candidate.rung.coefficients == coefficients) return candidate;
  return {};
}

/// A view's position, size and tilt, which determine what it contributes to a lens.
Eigen::Matrix<double, 6, 1> featuresOf(const BundleView& view, const CameraViews& camera) {
  Vec2 middle = Vec2::Zero();
  for (const Vec2& pixel : view.pixels) middle += pixel / static_cast<double>(view.pixels.size());
  // The affine map from board to image: its size and shape are the distance and the tilt.
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero(), mixed = Eigen::Matrix2d::Zero();
  for (std::size_t i = 0; i < view.pixels.size(); ++i) {
    const Vec2 on_board = (view.corners[i] - view.corners[0]).head<2>();
    spread += on_board * on_board.transpose();
    mixed += (view.pixels[i] - view.pixels[0]) * on_board.transpose();
  }
  const Eigen::Matrix2d affine = mixed * spread.inverse();
  const double size = std::sqrt(std::abs(affine.determinant())) + 1e-9;
  const Eigen::Matrix2d shape = affine * affine.transpose() / (size * size);
  Eigen::Matrix<double, 6, 1> features;
  features << 2 * middle.x() / camera.width, 2 * middle.y() / camera.width, 0.5 * std::log(size),
      0.5 * shape(0, 0), 0.5 * shape(1, 1), 0.5 * shape(0, 1);
  return features;
}

/// The most different views: each next one is the farthest from all previous ones (Gonzalez 1985).
std::vector<BundleView> selectSpreadViews(const std::vector<BundleView>& views, const CameraViews& camera,
                                          int most) {
  if (static_cast<int>(views.size()) <= most) return views;
  std::vector<double> nearest(views.size(), std::numeric_limits<double>::infinity());
  std::vector<BundleView> kept;
  const auto most_corners = std::max_element(
      views.begin(), views.end(),
      [](const BundleView& a, const BundleView& b) { return a.corners.size() < b.corners.size(); });
  std::size_t next = static_cast<std::size_t>(most_corners - views.begin());
  while (static_cast<int>(kept.size()) < most) {
    kept.push_back(views[next]);
    const auto features = featuresOf(views[next], camera);
    for (std::size_t i = 0; i < views.size(); ++i) {
      const double apart = (featuresOf(views[i], camera) - features).norm();
      // Prefers views with more corners.
      nearest[i] = std::min(nearest[i], apart * std::sqrt(static_cast<double>(views[i].corners.size())));
    }
    next = static_cast<std::size_t>(std::max_element(nearest.begin(), nearest.end()) - nearest.begin());
  }
  return kept;
}

}  // namespace

bool reachesCorners(const Lens& lens, int width, int height) {
  constexpr double kRim = 85 * M_PI / 180;
  if (lens.model == LensModel::kFisheye && lens.monotonic_limit >= kRim) return true;
  for (const double u : {0.0, width - 1.0})
    for (const double v : {0.0, height - 1.0})
      if (!rayThroughPixel(lens, {u, v})) return false;
  return true;
}

std::optional<BundleView> usableView(const Board& board, const BoardView& view) {
  if (static_cast<int>(view.ids.size()) < kFewestCorners) return std::nullopt;
  BundleView usable;
  Vec3 low = Vec3::Constant(1e9), high = -low;
  for (std::size_t i = 0; i < view.ids.size(); ++i) {
    usable.corners.push_back(board.corner(view.ids[i]));
    low = low.cwiseMin(usable.corners.back()), high = high.cwiseMax(usable.corners.back());
  }
  if ((high - low).head<2>().minCoeff() < 0.5 * board.square_m) return std::nullopt;
  usable.ids = view.ids;
  usable.pixels = view.pixels;
  usable.trusted.assign(view.ids.size(), 1);
  return usable;
}

std::vector<Pose> boardPoses(const Lens& lens, const BundleView& view) {
  std::vector<cv::Point3d> corners;
  std::vector<cv::Point2d> slopes;
  for (std::size_t i = 0; i < view.corners.size(); ++i) {
    if (!view.trusted[i]) continue;
    const std::optional<Vec3> ray = rayThroughPixel(lens, view.pixels[i]);
    if (!ray || !(ray->z() > 0) || ray->head<2>().norm() > kMaxSlope * ray->z()) continue;
    corners.emplace_back(view.corners[i].x(), view.corners[i].y(), 0);
    slopes.emplace_back(ray->x() / ray->z(), ray->y() / ray->z());
  }
  if (corners.size() < 4) return {};
  std::vector<cv::Mat> rotations, translations;
  try {
    cv::solvePnPGeneric(corners, slopes, cv::Matx33d::eye(), cv::noArray(), rotations, translations, false,
                        cv::SOLVEPNP_IPPE);
  } catch (const cv::Exception&) {
    return {};  // corners on a line
  }
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    const auto* w = rotations[i].ptr<double>();
    const auto* t = translations[i].ptr<double>();
    Pose pose = Pose::Identity();
    pose.linear() = rotationFromVector({w[0], w[1], w[2]});
    pose.translation() = Vec3(t[0], t[1], t[2]);
    if (!pose.matrix().allFinite()) continue;
    const bool is_before = std::all_of(view.corners.begin(), view.corners.end(),
                                       [&](const Vec3& corner) { return (pose * corner).z() > 0.01; });
    if (is_before) poses.push_back(pose);
  }
  return poses;
}

BundleCamera fitLens(const LensTask& task, const CalibrationOptions& options) {
  const CameraViews& camera = task.camera;
  const LensTask spread{camera, selectSpreadViews(task.views, camera, options.max_lens_views), task.done};
  Candidate candidate =
      options.lens == LensChoice::kAuto ? selectLens(spread) : requestedLens(spread, options.lens);
  const std::string prefix = "camera \"" + camera.name + "\": no lens fits its views of the board";
  if (candidate.bundle.cameras.empty())
    throw Error(prefix + "; expected the recorded board (--squares, --square-mm)");
  BundleCamera& found = candidate.bundle.cameras[0];
  if (found.noise_px > 0.01 * camera.width)
    throw Error(prefix + " to better than " + std::to_string(std::lround(found.noise_px)) +
                " pixels; expected the recorded board (--squares, --square-mm), held still");
  return found;
}

}  // namespace airclay
