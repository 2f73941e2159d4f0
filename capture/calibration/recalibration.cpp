// SPDX-License-Identifier: MIT
// Estimates the cameras' new poses from the views alone, in a new world. Each camera then implies the old
// world's pose if it had not moved; the cameras that agree have not moved.
#include "capture/calibration/recalibration.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "capture/calibration/calibration_parts.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

// A camera has not moved if the cube's centre and the world's rotation stay within these limits. A bumped
// tripod moves several times as much; calibrations with corners accurate to 0.1 px differ by less than half.
constexpr double kSamePosition_m = 0.0015;
constexpr double kSameRotation = 0.15 * M_PI / 180;
// The limits grow to three standard deviations of the uncertainty of a camera and of its boards, which other
// cameras determine no better; but a larger change than kMovedPosition_m or kMovedRotation always counts as
// movement.
constexpr double kDeviations = 3 * M_SQRT2;
constexpr double kMovedPosition_m = 0.005;
constexpr double kMovedRotation = 0.5 * M_PI / 180;
// If no two cameras agree, possibly because they are not synchronized, the limits are relaxed by this factor,
// which is better than losing the old world.
constexpr double kRelaxedTolerance = 3;
// A larger uncertainty of a camera's pose gives a warning.
constexpr double kUnsure_m = 0.001;
// An error of this size in the focal length displaces a point 1 m away by 5 mm along the ray.
constexpr double kSameFocal = 0.005;
// Relative difference of board sizes: less is the error of a ruler.
constexpr double kSameScale = 0.002;

std::string fixed(double value, int digits) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
}

/// "a", "b"
std::string listed(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "\"" : ", \"") + name + "\"";
  return list;
}

/// The views in the order of the rig's cameras. \pre checkSameCameras()
std::vector<CameraViews> inRigsOrder(const Rig& rig, const std::vector<CameraViews>& cameras) {
  std::vector<CameraViews> ordered;
  for (const Camera& camera : rig.cameras)
    ordered.push_back(*std::find_if(cameras.begin(), cameras.end(),
                                    [&](const CameraViews& views) { return views.name == camera.name; }));
  return ordered;
}

void addCameras(Bundle& bundle, const Rig& rig) {
  for (const Camera& camera : rig.cameras) {
    BundleCamera known;
    known.lens = camera.lens;
    known.free_center = false;
    known.half_diagonal_px = 0.5 * std::hypot(camera.width, camera.height);
    bundle.cameras.push_back(known);
  }
}

/// \throw Error naming a camera with too few shared views.
void checkShared(const Bundle& bundle, const Rig& rig) {
  const std::vector<int> shared = sharedViews(bundle);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c)
    if (shared[c] < kFewestShared)
      throw Error("camera \"" + rig.cameras[c].name + "\" shares " + std::to_string(shared[c]) +
                  (shared[c] == 1 ? " good view" : " good views") +
                  " of the board with other cameras; expected at least " + std::to_string(kFewestShared) +
                  ", better 10: hold it where this camera and another see it at the same time");
}

// --- which cameras moved ---

/// The old world's pose that a camera implies if it has not moved.
struct Claim {
  Pose old_from_new = Pose::Identity();
  PoseSigma sigma;
};

/// The estimated pose of the old world.
struct OldWorld {
  Pose old_from_new = Pose::Identity();
  double tolerance = 1;             ///< factor for kSamePosition_m and kSameRotation
  std::vector<std::size_t> still;   ///< the cameras that agree with it
  std::vector<std::size_t> rivals;  ///< an equally large group that agrees on another pose
  double board_scale = 1;           ///< with the board's size scaled by this, more cameras would agree
};

/// Transforms everything to another world.
void transformTo(Bundle& bundle, const Pose& other_from_world) {
  for (BundleCamera& camera : bundle.cameras)
    camera.camera_from_world = camera.camera_from_world * other_from_world.inverse();
  for (Pose& pose : bundle.world_from_board) pose = other_from_world * pose;
}

/// `scale`: the rig's lengths relative to the bundle's.
std::vector<Claim> claimsOf(const Rig& rig, const Bundle& bundle, const std::vector<PoseSigma>& sigmas,
                            double scale = 1) {
  std::vector<Claim> claims;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    Pose camera_from_new = bundle.cameras[c].camera_from_world;
    camera_from_new.translation() *= scale;
    claims.push_back({rig.cameras[c].camera_from_world.inverse() * camera_from_new, sigmas[c]});
  }
  return claims;
}

/// The weighted mean of these cameras' claims, which moves the cube's corners least (Umeyama 1991, weighted
/// by certainty).
Pose meanClaim(const std::vector<Claim>& claims, const std::vector<std::size_t>& of, const Workspace& cube) {
  constexpr double kSurest_m = 1e-4,
                   kLeastSure_m = 1;  // lenses limit the accuracy to a tenth of a millimetre
  std::vector<Vec3> in_new, in_old;
  std::vector<double> weights;
  Vec3 middle_in_new = Vec3::Zero();
  double sum = 0;
  for (const std::size_t c : of)
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 sides(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5);
      in_old.emplace_back(cube.center + cube.edge_m * sides);
      in_new.emplace_back(claims[c].old_from_new.inverse() * in_old.back());
      weights.push_back(1 / std::pow(std::clamp(claims[c].sigma.place_m, kSurest_m, kLeastSure_m), 2));
      middle_in_new += weights.back() * in_new.back();
      sum += weights.back();
    }
  middle_in_new /= sum;
  Mat3 products = Mat3::Zero();
  for (std::size_t i = 0; i < weights.size(); ++i)
    products += weights[i] * (in_old[i] - cube.center) * (in_new[i] - middle_in_new).transpose();
  const Eigen::JacobiSVD<Mat3> svd(products, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double handedness = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  Pose mean = Pose::Identity();
  mean.linear() = svd.matrixU() * Vec3(1, 1, handedness).asDiagonal() * svd.matrixV().transpose();
  mean.translation() = cube.center - mean.linear() * middle_in_new;
  return mean;
}

bool agrees(const Claim& claim, const OldWorld& tried, const Workspace& cube) {
  const Vec3 middle_in_new = tried.old_from_new.inverse() * cube.center;
  const double apart_m = (claim.old_from_new * middle_in_new - cube.center).norm();
  const double turn = angleBetween(claim.old_from_new.linear(), tried.old_from_new.linear());
  return apart_m <= std::clamp(kDeviations * claim.sigma.place_m, tried.tolerance * kSamePosition_m,
                               kMovedPosition_m) &&
         turn <= std::clamp(kDeviations * claim.sigma.turn, tried.tolerance * kSameRotation, kMovedRotation);
}

/// The largest group of `candidates` that agree; empty if no two do.
OldWorld largestGroup(const std::vector<Claim>& claims, const std::vector<std::size_t>& candidates,
                      const Workspace& cube, double tolerance = 1) {
  OldWorld best;
  for (const std::size_t seed : candidates) {
    OldWorld tried{claims[seed].old_from_new, tolerance, {}, {}};
    for (int round = 0; round < 4; ++round) {
      tried.still.clear();
      for (const std::size_t c : candidates)
        if (agrees(claims[c], tried, cube)) tried.still.push_back(c);
      if (tried.still.size() < 2) break;
      tried.old_from_new = meanClaim(claims, tried.still, cube);
    }
    if (tried.still.size() >= 2 && tried.still.size() > best.still.size()) best = tried;
  }
  return best;
}

std::vector<std::size_t> others(const std::vector<std::size_t>& group, std::size_t count) {
  std::vector<std::size_t> rest;
  for (std::size_t c = 0; c < count; ++c)
    if (std::find(group.begin(), group.end(), c) == group.end()) rest.push_back(c);
  return rest;
}

std::vector<std::string> namesOf(const Rig& rig, const std::vector<std::size_t>& cameras) {
  std::vector<std::string> names;
  for (const std::size_t c : cameras) names.push_back(rig.cameras[c].name);
  return names;
}

/// The scale of the board with which most cameras agree, if these are more than `most`; otherwise 1.
double betterBoardScale(const Rig& rig, const Bundle& bundle, const std::vector<PoseSigma>& sigmas,
                        std::size_t most) {
  const std::size_t count = rig.cameras.size();
  const auto apart = [](const Pose& a, const Pose& b) {
    return (a.inverse().translation() - b.inverse().translation()).norm();
  };
  double scale = 1;
  for (std::size_t a = 0; a < count; ++a)
    for (std::size_t b = 0; b < a; ++b) {
      const double tried = apart(rig.cameras[a].camera_from_world, rig.cameras[b].camera_from_world) /
                           apart(bundle.cameras[a].camera_from_world, bundle.cameras[b].camera_from_world);
      if (!std::isfinite(tried) || std::abs(tried - 1) < kSameScale) continue;
      const OldWorld old =
          largestGroup(claimsOf(rig, bundle, sigmas, tried), others({}, count), rig.workspace);
      if (old.still.size() > most) scale = tried, most = old.still.size();
    }
  return scale;
}

/// "squares of 55 mm instead of 53.9 mm; ..."
std::string otherSquares(const Board& board, double scale) {
  return "squares of " + inMillimetres(scale * board.square_m) + " mm instead of " +
         inMillimetres(board.square_m) +
         " mm; expected the size with which the rig was calibrated (--square-mm, --check-square-mm)";
}

/// The uncertainty of the cube's centre in each camera. \pre the bundle is approximately in the old world
std::vector<PoseSigma> sigmasAt(const Vec3& middle, Bundle bundle) {
  transformTo(bundle, Pose(Eigen::Translation3d(-middle)));
  return poseSigmas(bundle);
}

/// Estimates the old world; if no two cameras agree, the pose that moves the cube least. \throw Error if no
/// two agree, but at least three would with another board size
OldWorld findOldWorld(const Board& board, const Rig& rig, const Bundle& bundle,
                      const std::vector<PoseSigma>& sigmas) {
  const std::size_t count = rig.cameras.size();
  const std::vector<std::size_t> all = others({}, count);
  const std::vector<Claim> claims = claimsOf(rig, bundle, sigmas);
  OldWorld old = largestGroup(claims, all, rig.workspace);
  if (old.still.empty()) {
    if (const double scale = betterBoardScale(rig, bundle, sigmas, 2); scale != 1)
      throw Error("the cameras agree with the rig for a board with " + otherSquares(board, scale));
    old = largestGroup(claims, all, rig.workspace, kRelaxedTolerance);
  }
  if (old.still.empty()) {
    old.old_from_new = meanClaim(claims, all, rig.workspace);
    return old;
  }
  const OldWorld second = largestGroup(claims, others(old.still, count), rig.workspace, old.tolerance);
  if (second.still.size() == old.still.size()) old.rivals = second.still;
  // Two adjacent cameras agree for any board size, because both have the same error.
  if (old.still.size() < count)
    old.board_scale = betterBoardScale(rig, bundle, sigmas, std::max<std::size_t>(2, old.still.size()));
  return old;
}

void warnOfBoardSize(const Board& board, const OldWorld& old, std::vector<std::string>& warnings) {
  if (old.board_scale != 1)
    warnings.push_back("more cameras agree with the rig for a board with " +
                       otherSquares(board, old.board_scale));
}

void warnOfWorld(const Rig& rig, const OldWorld& old, std::vector<std::string>& warnings) {
  if (old.still.empty())
    warnings.push_back(
        "no two cameras have the same relative pose as before, so the old world is unknown: the cube is "
        "placed "
        "where it moves least for all of them; use --world N, a frame in which the board is on the table, to "
        "place it there");
  if (!old.rivals.empty())
    warnings.push_back("the cameras " + listed(namesOf(rig, old.still)) +
                       " have the same relative poses as before, and so do " +
                       listed(namesOf(rig, old.rivals)) +
                       ", but not both groups together: the first group is assumed not to have moved; if it "
                       "has, use --world N, "
                       "a frame in which the board is on the table, to define the world");
}

void warnOfPoses(const Rig& rig, const std::vector<PoseSigma>& sigmas, std::vector<std::string>& warnings) {
  for (std::size_t c = 0; c < rig.cameras.size(); ++c)
    if (!(sigmas[c].place_m <= kUnsure_m))
      warnings.push_back("camera \"" + rig.cameras[c].name + "\": its pose is uncertain" +
                         (std::isfinite(sigmas[c].place_m)
                              ? ": the cube's centre to " + fixed(1000 * sigmas[c].place_m, 1) + " mm"
                              : std::string()) +
                         "; show it the board for longer, near and tilted, together with another camera");
}

// --- how good it is ---

/// The reprojection errors of the same boards with the old rig and the best board poses. \pre `bundle` is in
/// the old world
void measureBefore(const Rig& rig, Bundle bundle, Recalibration& found) {
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    bundle.cameras[c].camera_from_world = rig.cameras[c].camera_from_world;
    bundle.cameras[c].noise_px = 1;  // a board follows the cameras that agree
  }
  AdjustOptions options;
  options.fix_lenses = options.fix_cameras = true;
  options.done = 0.95;
  adjust(bundle, options);
  std::vector<double> sums(rig.cameras.size(), 0), counts(rig.cameras.size(), 0);
  for (const BundleView& view : bundle.views) {
    const auto c = static_cast<std::size_t>(view.camera);
    const double most_px =
        2 * bundle.cameras[c].half_diagonal_px;  // the limit for corners that are not projected
    for (std::size_t i = 0; i < view.corners.size(); ++i) {
      if (!view.trusted[i]) continue;
      const double length = std::min(residualOf(bundle, view, i).norm(), most_px);
      sums[c] += length * length;
      ++counts[c];
    }
  }
  double sum = 0, count = 0;
  for (std::size_t c = 0; c < sums.size(); ++c) {
    found.changes[c].rms_px_before = std::sqrt(sums[c] / counts[c]);
    sum += sums[c], count += counts[c];
  }
  found.rms_px_before = std::sqrt(sum / count);
}

void measureChanges(const Rig& rig, const Bundle& bundle, const OldWorld& old, Recalibration& found) {
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const Pose before = rig.cameras[c].camera_from_world.inverse();
    const Pose now = bundle.cameras[c].camera_from_world.inverse();
    CameraChange change;
    change.moved_mm = 1000 * (now.translation() - before.translation()).norm();
    change.turned_deg = angleBetween(now.linear(), before.linear()) * 180 / M_PI;
    change.moved = std::find(old.still.begin(), old.still.end(), c) == old.still.end();
    found.changes.push_back(change);
  }
  found.world_kept = !old.still.empty();
}

/// Warns if the views fit another focal length better than the rig's, or have large errors for an unknown
/// reason. Returns whether a lens has changed.
bool warnOfLenses(Bundle bundle, Calibration& found) {
  AdjustOptions options;
  options.loss = Loss::kHuber;
  options.done = 0.95;
  adjust(bundle, options);
  const std::vector<double> sigmas = focalSigmas(bundle);
  bool other_lens = false;
  for (std::size_t c = 0; c < bundle.cameras.size(); ++c) {
    const Camera& camera = found.rig.cameras[c];
    const Lens& seen = bundle.cameras[c].lens;
    const double change = 0.5 * (seen.fx / camera.lens.fx + seen.fy / camera.lens.fy) - 1;
    const auto printWarning = [&](const std::string& text) {
      found.warnings.push_back("camera \"" + camera.name + "\": " + text);
    };
    if (std::abs(change) > std::max(kSameFocal, 4 * sigmas[c])) {
      other_lens = true;
      printWarning("its images fit a focal length " + fixed(100 * std::abs(change), 1) + " % " +
                   (change > 0 ? "longer" : "shorter") +
                   ", so its zoom or focus was changed; calibrate its lens again with `airclay calibrate`");
    } else if (found.cameras[c].rms_px > kMaxGoodRms_px) {
      printWarning("corners are off by " + fixed(found.cameras[c].rms_px, 2) +
                   " px; if its zoom or focus was changed, calibrate its lens again with `airclay "
                   "calibrate`; otherwise "
                   "use a flat, stiff board, and move it more slowly in more light");
    }
  }
  return other_lens;
}

void warnOfCube(const Rig& rig, std::vector<std::string>& warnings) {
  for (const Camera& camera : rig.cameras)
    if (!project(camera, rig.workspace.center))
      warnings.push_back("camera \"" + camera.name +
                         "\": it no longer sees the cube's centre; turn it back, and recalibrate again");
}

}  // namespace

void checkSameCameras(const Rig& rig, const std::vector<CameraViews>& cameras) {
  std::vector<std::string> missing, unknown;
  for (const Camera& camera : rig.cameras)
    if (std::none_of(cameras.begin(), cameras.end(),
                     [&](const CameraViews& views) { return views.name == camera.name; }))
      missing.push_back(camera.name);
  for (const CameraViews& views : cameras)
    if (std::none_of(rig.cameras.begin(), rig.cameras.end(),
                     [&](const Camera& camera) { return views.name == camera.name; }))
      unknown.push_back(views.name);
  std::string message;
  if (!missing.empty()) message = "there are no images of the rig's " + listed(missing);
  if (!unknown.empty())
    message += (message.empty() ? "" : ", and ") + listed(unknown) + (unknown.size() > 1 ? " are" : " is") +
               " not in the rig";
  if (!message.empty())
    throw Error(message + "; expected a recording of all of the rig's cameras, with the same names");
  for (const CameraViews& views : cameras)
    for (const Camera& camera : rig.cameras)
      if (views.name == camera.name && (views.width != camera.width || views.height != camera.height))
        throw Error("camera \"" + camera.name + "\": its images are " + std::to_string(views.width) + " x " +
                    std::to_string(views.height) + " pixels; expected the rig's " +
                    std::to_string(camera.width) + " x " + std::to_string(camera.height));
}

Recalibration recalibrate(const Board& board, const Rig& rig, const std::vector<CameraViews>& cameras,
                          const RecalibrationOptions& options) {
  checkSameCameras(rig, cameras);
  const std::vector<CameraViews> views = inRigsOrder(rig, cameras);
  Bundle bundle;
  try {
    bundle = gatherViews(board, views, {kFewestShared, 10});
    addCameras(bundle, rig);
    placeAll(bundle, views, true);
    checkShared(bundle, rig);
  } catch (const Error&) {
    checkBoardSize(board, views);
    throw;
  }

  Recalibration found;
  Calibration& calibration = found.calibration;
  const std::vector<PoseSigma> even(rig.cameras.size(), {0, 0});
  transformTo(bundle, meanClaim(claimsOf(rig, bundle, even), others({}, even.size()), rig.workspace));
  const std::vector<PoseSigma> sigmas = sigmasAt(rig.workspace.center, bundle);
  const OldWorld old = findOldWorld(board, rig, bundle, sigmas);
  transformTo(bundle, old.old_from_new);
  warnOfBoardSize(board, old, calibration.warnings);
  if (!options.world_frame) warnOfWorld(rig, old, calibration.warnings);
  measureChanges(rig, bundle, old, found);
  measureBefore(rig, bundle, found);
  calibration.rig = rig;
  if (options.world_frame) {
    const BundleView& world = worldView(bundle, options.world_frame);
    calibration.world_frame = world.frame;
    placeWorld(bundle, world, board);
    calibration.rig.workspace.center = Vec3(0, 0, rig.workspace.edge_m / 2);
  }
  for (std::size_t c = 0; c < rig.cameras.size(); ++c)
    calibration.rig.cameras[c].camera_from_world = bundle.cameras[c].camera_from_world;
  measure(bundle, calibration);
  if (!warnOfLenses(bundle, calibration)) warnOfSkew(bundle, calibration.warnings);
  warnOfPoses(rig, sigmas, calibration.warnings);
  warnOfCube(calibration.rig, calibration.warnings);
  return found;
}

}  // namespace airclay
