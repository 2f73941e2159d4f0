// SPDX-License-Identifier: MIT
// The sequence of steps of a calibration.
#include "capture/calibration/calibration.h"

#include "capture/calibration/calibration_parts.h"
#include "engine/core/error.h"
#include "engine/core/task.h"

namespace airclay {
namespace {

std::vector<BundleView> viewsOf(const Bundle& bundle, std::size_t camera) {
  std::vector<BundleView> views;
  for (const BundleView& view : bundle.views)
    if (view.camera == static_cast<int>(camera)) views.push_back(view);
  return views;
}

Rig rigFrom(const Bundle& bundle, const std::vector<CameraViews>& cameras,
            const CalibrationOptions& options) {
  Rig rig;
  for (std::size_t c = 0; c < cameras.size(); ++c)
    rig.cameras.push_back({cameras[c].name, cameras[c].width, cameras[c].height, bundle.cameras[c].lens,
                           bundle.cameras[c].camera_from_world});
  rig.workspace.edge_m = options.edge_m;
  if (options.world_frame) rig.workspace.center = Vec3(0, 0, options.edge_m / 2);
  if (options.center) rig.workspace.center = *options.center;
  return rig;
}

Bundle placedBundle(const Board& board, const std::vector<CameraViews>& cameras,
                    const CalibrationOptions& options) {
  Bundle bundle = gatherViews(board, cameras, {kFewestViews, 30});
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const double done = kLensesShare * static_cast<double>(c) / static_cast<double>(cameras.size());
    bundle.cameras.push_back(fitLens({cameras[c], viewsOf(bundle, c), done}, options));
  }
  reportProgress(kLensesShare);
  placeAll(bundle, cameras, false);
  return bundle;
}

}  // namespace

Calibration calibrate(const Board& board, const std::vector<CameraViews>& cameras,
                      const CalibrationOptions& options) {
  if (cameras.size() < 2 || cameras.size() > kMaxCameras)
    throw Error("a rig of " + std::to_string(cameras.size()) +
                (cameras.size() == 1 ? " camera" : " cameras") + " cannot be calibrated; expected 2 to " +
                std::to_string(kMaxCameras));
  Bundle bundle;
  try {
    bundle = placedBundle(board, cameras, options);
  } catch (const Error&) {
    checkBoardSize(board, cameras);
    throw;
  }
  Calibration calibration;

  const BundleView& world = worldView(bundle, options.world_frame);
  calibration.world_frame = world.frame;
  placeWorld(bundle, world, board);
  calibration.rig = rigFrom(bundle, cameras, options);
  reportProgress(0.95);
  report(bundle, calibration);
  return calibration;
}

}  // namespace airclay
