// SPDX-License-Identifier: MIT
// Recalibrates a rig whose cameras were partly moved, from a short recording of a waved board. The lenses are
// known and fixed, and the world is kept where the cameras that did not move define it.
#pragma once

#include "capture/calibration/calibration.h"

namespace airclay {

struct RecalibrationOptions {
  /// The frame whose board defines a new world, as in CalibrationOptions; the cube is then on the board.
  /// Default: the world is kept.
  std::optional<int> world_frame;
};

/// The minimum number of views per camera that another camera shares: a single board allows two poses, and
/// three can outvote a wrong one.
inline constexpr int kFewestShared = 3;

/// The change of one camera relative to the old rig.
struct CameraChange {
  double moved_mm = 0;    ///< of its centre of projection
  double turned_deg = 0;  ///< rotation
  bool moved = false;     ///< false: it is one of the cameras that define the world
  double rms_px_before =
      0;  ///< reprojection error of the same corners with the old rig and the best board poses
};

struct Recalibration {
  Calibration calibration;            ///< the new rig, its quality, and the warnings
  std::vector<CameraChange> changes;  ///< one per camera, in the rig's order
  double rms_px_before = 0;           ///< over all cameras' corners
  /// At least two cameras have the same relative pose as before, which defines the old world. Otherwise,
  /// without a world frame, the world is where the cube moves least for all cameras together.
  bool world_kept = false;
};

/// \throw Error, listing all differences, unless the rig and the recording have cameras of the same names and
/// sizes, in any order. Does not use the views.
void checkSameCameras(const Rig& rig, const std::vector<CameraViews>& cameras);

/// Recalibrates a rig; calls reportProgress(). \pre the views' ids are those of the board; the rig passes
/// checkRig() \throw Error like checkSameCameras(), or naming the camera and the remedy if a camera has too
/// few views or too few that agree with another camera's, no chain of shared views connects all cameras, the
/// board has another size than that of the rig, or the world frame shows no board.
Recalibration recalibrate(const Board& board, const Rig& rig, const std::vector<CameraViews>& cameras,
                          const RecalibrationOptions& options = {});

}  // namespace airclay
