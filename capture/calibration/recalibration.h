// SPDX-License-Identifier: MIT
// A rig some of whose cameras were bumped, put right from a short recording of a waved board: the lenses are
// known and held, and the world stays where the cameras that did not move say that it is.
#pragma once

#include "capture/calibration/calibration.h"

namespace airclay {

struct RecalibrationOptions {
  /// The frame in which the board lies where the world shall be from now on, as in CalibrationOptions; the
  /// cube then stands on it. Without: the world stays.
  std::optional<int> world_frame;
};

/// A camera needs so many views that another one shares: one board alone leaves two poses, and three outvote
/// a wrong one.
inline constexpr int kFewestShared = 3;

/// What became of one camera.
struct CameraChange {
  double moved_mm = 0;       ///< its centre of projection, from where the old rig has it
  double turned_deg = 0;     ///< from how the old rig has it
  bool moved = false;        ///< else it is one of those that keep the world
  double rms_px_before = 0;  ///< of the same corners, with the old rig, wherever the boards fit best
};

struct Recalibration {
  Calibration calibration;            ///< the new rig, how good it is, and the warnings
  std::vector<CameraChange> changes;  ///< one a camera, in the rig's order
  double rms_px_before = 0;           ///< over all cameras' corners
  /// Two cameras or more stand to each other as before, so it is known where the world was. Otherwise, unless
  /// a frame says where it shall be, it lies where the cube moves least for all cameras together.
  bool world_kept = false;
};

/// \throw Error unless the rig and the recording have cameras of the same names and sizes, in any order; it
/// names all that are amiss. Of the recording's cameras no view is looked at.
void checkSameCameras(const Rig& rig, const std::vector<CameraViews>& cameras);

/// Tells reportProgress() how far it is. \pre the views' ids are the board's, the rig is one of readRig()
/// \throw Error as checkSameCameras(); or naming the camera and what to do: a camera with too few views, or
/// too few that agree with another's; cameras that no chain of shared views connects; a lens that is no
/// longer the rig's; a board of another size than the rig's; a world frame without a board.
Recalibration recalibrate(const Board& board, const Rig& rig, const std::vector<CameraViews>& cameras,
                          const RecalibrationOptions& options = {});

}  // namespace airclay
