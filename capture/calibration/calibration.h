// SPDX-License-Identifier: MIT
// From views of a waved board to a calibrated rig: each camera's lens, then where the cameras stand, then all
// of it at once.
//
// calibration_lens finds a camera's lens, calibration_chain the cameras' places through the boards that two
// of them saw at once, calibration_bundle adjusts everything together, calibration_report says how good it
// is. recalibration.h uses them where the lenses are known.
#pragma once

#include <map>
#include <optional>

#include "capture/calibration/board.h"
#include "engine/camera/rig.h"

namespace airclay {

/// What one camera saw of the board, by the number of the frame: one number, one instant in all cameras.
struct CameraViews {
  std::string name;
  int width = 0, height = 0;  ///< pixels
  std::map<int, BoardView> views;
};

/// kAuto: as few of the perspective model's coefficients as explain the views; fisheye where that model alone
/// can. The others: so many coefficients.
enum class LensChoice { kAuto, kFive, kEight, kFisheye };

struct CalibrationOptions {
  LensChoice lens = LensChoice::kAuto;
  /// The frame in which the board lies where the world shall be: origin in its middle, x along its rows, z up
  /// out of its face. Without: the first of the frames that most cameras see best.
  std::optional<int> world_frame;
  /// The cube's middle, metres, world. Without: half an edge above the board of `world_frame`, so that the
  /// cube stands on the table; or the origin, where no frame is named.
  std::optional<Vec3> center;
  double edge_m = 0.6;
  int max_lens_views = 50;  ///< of a camera, from which its lens is first found; all are used in the end
};

/// A camera needs so many views.
inline constexpr int kFewestViews = 8;

/// Of fewer views, of a lesser share of the image, or of fewer views that another camera shares, it is
/// warned: fewer views leave a lens to chance; a cube that fills the middle of the image needs no more than
/// half of it.
inline constexpr int kFewViews = 20;
inline constexpr double kPoorCoverage = 0.3;
inline constexpr int kFewShared = 10;

/// How well one camera is known.
struct CameraQuality {
  int views = 0;         ///< used
  int shared_views = 0;  ///< of them, those of boards that another camera saw at the same time
  int corners = 0;       ///< used
  int dropped = 0;       ///< corners that no pose of the board explains, of these views and of others
  double rms_px = 0;     ///< of the used corners' distances from where the rig projects them
  double coverage = 0;   ///< share of the image, in cells of an eighth of its width, where a corner was seen
  std::string bare_sides;  ///< of the image, where hardly any was: "left, top"
  double focal_sigma = 0;  ///< standard deviation of the focal length, relative to it
};

/// Two cameras and how far they stand apart.
struct Baseline {
  int a = 0, b = 0;
  double metres = 0;
};

/// A used corner: where it was seen, and how far from where the rig projects it.
struct CornerResidual {
  int camera = 0, frame = 0;
  Vec2 pixel = Vec2::Zero();
  Vec2 error_px = Vec2::Zero();  ///< seen - projected
};

struct Calibration {
  Rig rig;
  std::vector<CameraQuality> cameras;
  double rms_px = 0;  ///< over all cameras' corners
  /// RMS error of the distances between a board's corners that two cameras or more triangulate, in mm; none
  /// when no two cameras saw one corner.
  std::optional<double> scale_error_mm;
  std::vector<Baseline> baselines;
  int world_frame = 0;
  std::vector<Pose> world_from_boards;  ///< where the board was, one a frame that several cameras agree on
  std::vector<CornerResidual> residuals;
  std::vector<std::string> warnings;  ///< a line each: what is poor, at which camera, and what to do
};

/// Tells reportProgress() how far it is. \pre the views' ids are the board's.
/// \throw Error naming the camera and what to do: fewer than two cameras; a camera with too few views, or
/// whose views no lens explains; cameras that no chain of shared views connects; a world frame without a
/// board.
Calibration calibrate(const Board& board, const std::vector<CameraViews>& cameras,
                      const CalibrationOptions& options = {});

/// Draws the rig from above and from the side, with the boards, and each camera's residuals, a hundred times
/// as long. \throw Error when the file cannot be written.
void drawCalibration(const std::filesystem::path& png, const Board& board, const Calibration& calibration);

}  // namespace airclay
