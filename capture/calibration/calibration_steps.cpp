// SPDX-License-Identifier: MIT
// The steps common to calibration and recalibration: usable views, board poses, joint adjustment, and the
// world.
#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/calibration/board_advice.h"
#include "capture/calibration/calibration_parts.h"
#include "engine/core/error.h"
#include "engine/core/median.h"

namespace airclay {
namespace {

// A view with a larger error before the first adjustment will never fit its board's pose.
constexpr double kMaxViewError_px = 100;

/// The poses that a view allows, computed again without outliers, which would distort them.
std::vector<Pose> robustPoses(const Lens& lens, BundleView view) {
  const std::vector<Pose> poses = boardPoses(lens, view);
  if (poses.empty()) return poses;
  std::vector<double> errors;
  for (std::size_t i = 0; i < view.corners.size(); ++i) {
    const std::optional<Vec2> projected = projectThroughLens(lens, poses[0] * view.corners[i]);
    errors.push_back(projected ? (*projected - view.pixels[i]).norm() : 1e6);
  }
  const double usual = median(errors);
  for (std::size_t i = 0; i < errors.size(); ++i) view.trusted[i] = errors[i] <= 3 * usual;
  const std::vector<Pose> again = boardPoses(lens, view);
  return again.empty() ? poses : again;
}

/// Gives a view that contradicts its board's other views a separate stand: unsynchronized cameras see the
/// board in different places. The view still contributes to its lens. `patience_px`: a tolerance above the
/// camera's noise while the cameras' poses are inaccurate.
void separate(Bundle& bundle, const ViewPoses& poses, double patience_px) {
  std::vector<int> sharers(bundle.world_from_board.size(), 0);
  for (const BundleView& view : bundle.views) ++sharers[static_cast<std::size_t>(view.stand)];
  for (std::size_t i = 0; i < bundle.views.size(); ++i) {
    BundleView& view = bundle.views[i];
    const BundleCamera& camera = bundle.cameras[static_cast<std::size_t>(view.camera)];
    int& sharing = sharers[static_cast<std::size_t>(view.stand)];
    const double limit_px = std::max(trustedRadius(camera.noise_px), patience_px);
    if (sharing < 2 || median(residualLengths(bundle, view)) <= limit_px) continue;
    --sharing;
    view.stand = static_cast<int>(bundle.world_from_board.size());
    bundle.world_from_board.push_back(camera.camera_from_world.inverse() * poses[i][0]);
    sharers.push_back(1);
  }
}

void measureNoise(Bundle& bundle) {
  for (std::size_t c = 0; c < bundle.cameras.size(); ++c)
    bundle.cameras[c].noise_px = robustNoise(bundle, static_cast<int>(c));
}

/// Both board poses of each view; removes views without a pose.
ViewPoses posesOfViews(Bundle& bundle) {
  ViewPoses poses;
  std::vector<BundleView> kept;
  for (BundleView& view : bundle.views) {
    std::vector<Pose> of_view = robustPoses(bundle.cameras[static_cast<std::size_t>(view.camera)].lens, view);
    if (of_view.empty()) continue;
    poses.push_back(std::move(of_view));
    kept.push_back(std::move(view));
  }
  bundle.views = std::move(kept);
  return poses;
}

/// Selects each board's pose with the smallest error in all cameras that see it; a single view allows two
/// poses.
void placeBoards(Bundle& bundle, const ViewPoses& poses) {
  constexpr double kWorst_px = 30;
  std::vector<std::vector<std::size_t>> views_of_stand(bundle.world_from_board.size());
  for (std::size_t i = 0; i < bundle.views.size(); ++i)
    views_of_stand[static_cast<std::size_t>(bundle.views[i].stand)].push_back(i);
  for (std::size_t stand = 0; stand < views_of_stand.size(); ++stand) {
    Pose best = Pose::Identity();
    double least = std::numeric_limits<double>::infinity();
    for (const std::size_t proposer : views_of_stand[stand])
      for (const Pose& camera_from_board : poses[proposer]) {
        const auto camera = static_cast<std::size_t>(bundle.views[proposer].camera);
        bundle.world_from_board[stand] =
            bundle.cameras[camera].camera_from_world.inverse() * camera_from_board;
        double cost = 0;
        for (const std::size_t judge : views_of_stand[stand])
          for (const double length : residualLengths(bundle, bundle.views[judge]))
            cost += std::min(length, kWorst_px);
        if (cost < least) best = bundle.world_from_board[stand], least = cost;
      }
    bundle.world_from_board[stand] = best;
  }
}

/// Robust joint adjustment, repeated without outlier corners and with contradictory views separated.
void adjustAll(Bundle& bundle, const ViewPoses& poses, bool fix_lenses) {
  AdjustOptions options;
  options.done = kLensesShare;
  options.fix_lenses = true;  // the chain's poses are still inaccurate and must not distort the lenses
  for (BundleCamera& camera : bundle.cameras) camera.noise_px = std::max(camera.noise_px, 1.0);
  separate(bundle, poses, kMaxViewError_px);
  adjust(bundle, options);
  options.fix_lenses = fix_lenses;
  for (const double done : {0.6, 0.7, 0.8}) {
    options.done = done;
    measureNoise(bundle);
    separate(bundle, poses, 0);
    adjust(bundle, options);
  }
  measureNoise(bundle);
  for (const double done : {0.85, 0.9}) {
    options.done = done;
    trustNearCorners(bundle);
    options.loss = Loss::kHuber;
    adjust(bundle, options);
    measureNoise(bundle);
  }
  trustNearCorners(bundle);
}

/// \throw Error if a camera has no board in common with another one.
void checkPlaced(const Bundle& bundle, const std::vector<CameraViews>& cameras) {
  const std::vector<int> shared = sharedViews(bundle);
  for (std::size_t c = 0; c < cameras.size(); ++c)
    if (shared[c] == 0)
      throw Error("camera \"" + cameras[c].name +
                  "\": in no frame does it agree with another camera on the board's position; synchronize "
                  "the cameras, "
                  "or hold the board still now and then");
}

}  // namespace

Bundle gatherViews(const Board& board, const std::vector<CameraViews>& cameras, const ViewsNeeded& needed) {
  Bundle bundle;
  std::map<int, int> stand_of_frame;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    int usable = 0;
    for (const auto& [frame, seen] : cameras[c].views) {
      std::optional<BundleView> view = usableView(board, seen);
      if (!view) continue;
      const auto [stand, is_new] = stand_of_frame.emplace(frame, static_cast<int>(stand_of_frame.size()));
      view->camera = static_cast<int>(c), view->frame = frame, view->stand = stand->second;
      bundle.views.push_back(std::move(*view));
      ++usable;
    }
    if (usable < needed.fewest)
      throw Error("camera \"" + cameras[c].name + "\" sees the board well in " + std::to_string(usable) +
                  (usable == 1 ? " frame" : " frames") + "; expected at least " +
                  std::to_string(needed.fewest) + ", better " + std::to_string(needed.better) +
                  ": wave it slowly in front of every camera");
  }
  bundle.world_from_board.resize(stand_of_frame.size(), Pose::Identity());
  return bundle;
}

void checkBoardSize(const Board& board, const std::vector<CameraViews>& cameras) {
  double smallest_px = std::numeric_limits<double>::infinity();
  std::string name;
  for (const CameraViews& camera : cameras) {
    std::vector<const BoardView*> views;
    for (const auto& [frame, view] : camera.views) views.push_back(&view);
    const std::optional<double> marker_px = markerPixels(board, views);
    if (marker_px && *marker_px < smallest_px) smallest_px = *marker_px, name = camera.name;
  }
  const std::string reason = describeSmallBoard(board, smallest_px);
  if (!reason.empty()) throw Error("camera \"" + name + "\": " + reason);
}

std::vector<int> sharersOfStands(const Bundle& bundle) {
  std::vector<int> sharers(bundle.world_from_board.size(), 0);
  for (const BundleView& view : bundle.views)
    sharers[static_cast<std::size_t>(view.stand)] += view.trustedCount() > 0;
  return sharers;
}

std::vector<int> sharedViews(const Bundle& bundle) {
  const std::vector<int> sharers = sharersOfStands(bundle);
  std::vector<int> shared(bundle.cameras.size(), 0);
  for (const BundleView& view : bundle.views)
    shared[static_cast<std::size_t>(view.camera)] +=
        view.trustedCount() > 0 && sharers[static_cast<std::size_t>(view.stand)] > 1;
  return shared;
}

void placeAll(Bundle& bundle, const std::vector<CameraViews>& cameras, bool fix_lenses) {
  const ViewPoses poses = posesOfViews(bundle);
  chainCameras(bundle, poses, cameras);
  placeBoards(bundle, poses);
  adjustAll(bundle, poses, fix_lenses);
  checkPlaced(bundle, cameras);
}

const BundleView& worldView(const Bundle& bundle, std::optional<int> frame) {
  std::vector<std::pair<int, int>> votes(bundle.world_from_board.size());  // cameras, corners
  for (const BundleView& view : bundle.views) {
    auto& [cameras, corners] = votes[static_cast<std::size_t>(view.stand)];
    cameras += view.trustedCount() > 0, corners += view.trustedCount();
  }
  const BundleView* best = nullptr;
  for (const BundleView& view : bundle.views) {
    if (view.trustedCount() == 0 || (frame && view.frame != *frame)) continue;
    const auto vote = votes[static_cast<std::size_t>(view.stand)];
    const auto most = best ? votes[static_cast<std::size_t>(best->stand)] : std::pair(0, 0);
    if (vote > most || (vote == most && best && view.frame < best->frame)) best = &view;
  }
  if (!best)
    throw Error("--world " + std::to_string(frame.value_or(0)) +
                ": no camera sees the board well in this frame; expected one in which it is on the table and "
                "visible in "
                "several cameras");
  return *best;
}

void placeWorld(Bundle& bundle, const BundleView& view, const Board& board) {
  Pose board_from_world = Pose::Identity();
  board_from_world.linear() = Vec3(1, -1, -1).asDiagonal();
  board_from_world.translation() = 0.5 * board.square_m * Vec3(board.squares_x, board.squares_y, 0);
  const Pose old_from_world =
      bundle.world_from_board[static_cast<std::size_t>(view.stand)] * board_from_world;
  for (BundleCamera& camera : bundle.cameras)
    camera.camera_from_world = camera.camera_from_world * old_from_world;
  for (Pose& pose : bundle.world_from_board) pose = old_from_world.inverse() * pose;
}

}  // namespace airclay
