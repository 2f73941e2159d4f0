// SPDX-License-Identifier: MIT
// Where the cameras are now comes from the views alone, in a world of its own. Then each camera says where
// the old world would be if it had not moved; those that say the same have not.
#include "capture/calibration/recalibration.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "capture/calibration/calibration_parts.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

// As long as the cube's middle stays within this, and the world is not turned by more, a camera has not
// moved. What a bumped tripod does is several times as much; what rigs by corners that are good to 0.1 px are
// off by is less than half of it.
constexpr double kSamePlace_m = 0.0015;
constexpr double kSameTurn = 0.15 * M_PI / 180;
// Nor by what its views leave open: three standard deviations, of a camera and of the boards by which it is
// placed, which another camera knows no better. But this is a bump, however little is known.
constexpr double kDeviations = 3 * M_SQRT2;
constexpr double kOtherPlace_m = 0.005;
constexpr double kOtherTurn = 0.5 * M_PI / 180;
// Where no two agree, cameras that are not synchronised may be the reason: so many times as far apart are
// still better than no old world.
constexpr double kMorePatience = 3;
// A camera that is known less surely is said to be.
constexpr double kUnsure_m = 0.001;
// A focal length that is off by so much misplaces a point 1 m away by 5 mm along the ray.
constexpr double kSameFocal = 0.005;
// Of the size of a board: less is a ruler's error.
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

/// \throw Error naming a camera that too few views place.
void checkShared(const Bundle& bundle, const Rig& rig) {
  const std::vector<int> shared = sharedViews(bundle);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c)
    if (shared[c] < kFewestShared)
      throw Error("camera \"" + rig.cameras[c].name + "\" shares " + std::to_string(shared[c]) +
                  (shared[c] == 1 ? " good view" : " good views") +
                  " of the board with other cameras; at least " + std::to_string(kFewestShared) +
                  ", better 10, would be right: hold it where this camera and another see it at once");
}

// --- which cameras moved ---

/// What a camera says of where the old world lies in the new one, if it has not moved.
struct Claim {
  Pose old_from_new = Pose::Identity();
  PoseSigma sigma;
};

/// Where it does lie.
struct OldWorld {
  Pose old_from_new = Pose::Identity();
  double patience = 1;              ///< so many times kSamePlace_m and kSameTurn apart is still the same
  std::vector<std::size_t> still;   ///< the cameras that say so
  std::vector<std::size_t> rivals;  ///< as many that say it lies elsewhere
  double board_scale = 1;           ///< times this, the board's size would let more cameras agree
};

/// Moves everything into another world.
void moveInto(Bundle& bundle, const Pose& other_from_world) {
  for (BundleCamera& camera : bundle.cameras)
    camera.camera_from_world = camera.camera_from_world * other_from_world.inverse();
  for (Pose& pose : bundle.world_from_board) pose = other_from_world * pose;
}

/// `scale`: the bundle's lengths times this are the rig's.
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

/// Between the claims of these cameras: the cube's corners move least from where each puts them, the surer
/// the less (Umeyama 1991, weighted).
Pose meanClaim(const std::vector<Claim>& claims, const std::vector<std::size_t>& of, const Workspace& cube) {
  constexpr double kSurest_m = 1e-4, kLeastSure_m = 1;  // lenses leave a tenth of a millimetre open
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
  return apart_m <=
             std::clamp(kDeviations * claim.sigma.place_m, tried.patience * kSamePlace_m, kOtherPlace_m) &&
         turn <= std::clamp(kDeviations * claim.sigma.turn, tried.patience * kSameTurn, kOtherTurn);
}

/// The most of `candidates` that say the same; of one camera alone nothing is said.
OldWorld largestGroup(const std::vector<Claim>& claims, const std::vector<std::size_t>& candidates,
                      const Workspace& cube, double patience = 1) {
  OldWorld best;
  for (const std::size_t seed : candidates) {
    OldWorld tried{claims[seed].old_from_new, patience, {}, {}};
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

/// The scale of the board by which most cameras agree, if these are more than `most`; otherwise 1.
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
         " mm; the size by which the rig was calibrated (--square-mm, --check-square-mm) would be right";
}

/// How surely each camera sees the cube's middle where it is. \pre the bundle is nearly in the old world
std::vector<PoseSigma> sigmasAt(const Vec3& middle, Bundle bundle) {
  moveInto(bundle, Pose(Eigen::Translation3d(-middle)));
  return poseSigmas(bundle);
}

/// Without two cameras that agree on it, the cube moves least. \throw Error when no two agree, but three or
/// more would if the board had another size
OldWorld findOldWorld(const Board& board, const Rig& rig, const Bundle& bundle,
                      const std::vector<PoseSigma>& sigmas) {
  const std::size_t count = rig.cameras.size();
  const std::vector<std::size_t> all = others({}, count);
  const std::vector<Claim> claims = claimsOf(rig, bundle, sigmas);
  OldWorld old = largestGroup(claims, all, rig.workspace);
  if (old.still.empty()) {
    if (const double scale = betterBoardScale(rig, bundle, sigmas, 2); scale != 1)
      throw Error("the cameras agree with the rig for a board with " + otherSquares(board, scale));
    old = largestGroup(claims, all, rig.workspace, kMorePatience);
  }
  if (old.still.empty()) {
    old.old_from_new = meanClaim(claims, all, rig.workspace);
    return old;
  }
  const OldWorld second = largestGroup(claims, others(old.still, count), rig.workspace, old.patience);
  if (second.still.size() == old.still.size()) old.rivals = second.still;
  // Two cameras side by side agree on a board of any size: both are off by the same.
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
        "no two cameras stand to each other as before, so where the world was is not known: the cube is "
        "put where it moves least for all of them; --world N, a frame in which the board lies on the table, "
        "puts it there");
  if (!old.rivals.empty())
    warnings.push_back(
        "the cameras " + listed(namesOf(rig, old.still)) + " stand to each other as before, and so do " +
        listed(namesOf(rig, old.rivals)) +
        ", but these not to those: the first are taken to be where they were; where it is the others, "
        "--world N, a frame in which the board lies on the table, says where the world is");
}

void warnOfPoses(const Rig& rig, const std::vector<PoseSigma>& sigmas, std::vector<std::string>& warnings) {
  for (std::size_t c = 0; c < rig.cameras.size(); ++c)
    if (!(sigmas[c].place_m <= kUnsure_m))
      warnings.push_back("camera \"" + rig.cameras[c].name + "\": its place is hardly known" +
                         (std::isfinite(sigmas[c].place_m)
                              ? ": the cube's middle is sure to " + fixed(1000 * sigmas[c].place_m, 1) + " mm"
                              : std::string()) +
                         "; show it the board longer, near and tilted, together with another camera");
}

// --- how good it is ---

/// The same boards seen with the old rig: each where it fits best. \pre `bundle` is in the old world
void measureBefore(const Rig& rig, Bundle bundle, Recalibration& found) {
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    bundle.cameras[c].camera_from_world = rig.cameras[c].camera_from_world;
    bundle.cameras[c].noise_px = 1;  // a board goes with the cameras that agree
  }
  AdjustOptions options;
  options.fix_lenses = options.fix_cameras = true;
  options.done = 0.95;
  adjust(bundle, options);
  std::vector<double> sums(rig.cameras.size(), 0), counts(rig.cameras.size(), 0);
  for (const BundleView& view : bundle.views) {
    const auto c = static_cast<std::size_t>(view.camera);
    const double most_px = 2 * bundle.cameras[c].half_diagonal_px;  // what isn't projected is far off
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

/// Warns where the views would rather have another focal length than the rig's, or are off for no reason that
/// is known. Whether there was another lens.
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
      printWarning("its images are like those of a focal length " + fixed(100 * std::abs(change), 1) + " % " +
                   (change > 0 ? "longer" : "shorter") +
                   ", so its zoom or focus was changed; `airclay calibrate` finds its lens anew");
    } else if (found.cameras[c].rms_px > kHighRms_px) {
      printWarning(
          "corners are off by " + fixed(found.cameras[c].rms_px, 2) +
          " px; where its zoom or focus was changed, `airclay calibrate` finds its lens anew, otherwise a "
          "flat, stiff board, moved more slowly in more light, would be better");
    }
  }
  return other_lens;
}

void warnOfCube(const Rig& rig, std::vector<std::string>& warnings) {
  for (const Camera& camera : rig.cameras)
    if (!project(camera, rig.workspace.center))
      warnings.push_back(
          "camera \"" + camera.name +
          "\": it does not see the cube's middle any more; turn it back, and recalibrate again");
}

}  // namespace

void checkSameCameras(const Rig& rig, const std::vector<CameraViews>& cameras) {
  std::vector<std::string> lacking, foreign;
  for (const Camera& camera : rig.cameras)
    if (std::none_of(cameras.begin(), cameras.end(),
                     [&](const CameraViews& views) { return views.name == camera.name; }))
      lacking.push_back(camera.name);
  for (const CameraViews& views : cameras)
    if (std::none_of(rig.cameras.begin(), rig.cameras.end(),
                     [&](const Camera& camera) { return views.name == camera.name; }))
      foreign.push_back(views.name);
  std::string fault;
  if (!lacking.empty()) fault = "there are no images of the rig's " + listed(lacking);
  if (!foreign.empty())
    fault += (fault.empty() ? "" : ", and ") + listed(foreign) + (foreign.size() > 1 ? " are" : " is") +
             " not in the rig";
  if (!fault.empty())
    throw Error(fault + "; a recording of all of the rig's cameras, under their names, would be right");
  for (const CameraViews& views : cameras)
    for (const Camera& camera : rig.cameras)
      if (views.name == camera.name && (views.width != camera.width || views.height != camera.height))
        throw Error("camera \"" + camera.name + "\": its images are " + std::to_string(views.width) + " x " +
                    std::to_string(views.height) + " pixels, the rig's " + std::to_string(camera.width) +
                    " x " + std::to_string(camera.height) +
                    "; images of the size that the rig was calibrated for would be right");
}

Recalibration recalibrate(const Board& board, const Rig& rig, const std::vector<CameraViews>& cameras,
                          const RecalibrationOptions& options) {
  checkSameCameras(rig, cameras);
  const std::vector<CameraViews> views = inRigsOrder(rig, cameras);
  Bundle bundle = gatherViews(board, views, {kFewestShared, 10});
  addCameras(bundle, rig);
  placeAll(bundle, views, true);
  checkShared(bundle, rig);

  Recalibration found;
  Calibration& calibration = found.calibration;
  const std::vector<PoseSigma> even(rig.cameras.size(), {0, 0});
  moveInto(bundle, meanClaim(claimsOf(rig, bundle, even), others({}, even.size()), rig.workspace));
  const std::vector<PoseSigma> sigmas = sigmasAt(rig.workspace.center, bundle);
  const OldWorld old = findOldWorld(board, rig, bundle, sigmas);
  moveInto(bundle, old.old_from_new);
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
