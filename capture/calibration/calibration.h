// SPDX-License-Identifier: MIT
// Calibrates a rig from views of a waved board: each camera's lens, then the cameras' poses, then a joint
// adjustment.
//
// calibration_lens estimates a camera's lens, calibration_chain the cameras' poses from boards that two of
// them see at the same time, calibration_bundle adjusts everything jointly, and calibration_report assesses
// the result. recalibration.h uses these for rigs with known lenses.
#pragma once

#include <map>
#include <optional>

#include "capture/calibration/board.h"
#include "engine/camera/rig.h"

namespace airclay {

/// One camera's views of the board by frame number; a number denotes the same instant in all cameras.
struct CameraViews {
  std::string name;
  int width = 0, height = 0;  ///< pixels
  std::map<int, BoardView> views;
};

/// kAuto: the fewest coefficients of the perspective model that fit the views; fisheye if only that model
/// fits. The others: a fixed number of coefficients.
enum class LensChoice { kAuto, kFive, kEight, kFisheye };

struct CalibrationOptions {
  LensChoice lens = LensChoice::kAuto;
  /// The frame whose board defines the world: origin at its centre, x along its rows, z up from its face.
  /// Default: the first of the frames that most cameras see best.
  std::optional<int> world_frame;
  /// The cube's centre, metres, world. Default: half an edge above the board of `world_frame`, so that the
  /// cube is on the table; the origin if there is no `world_frame`.
  std::optional<Vec3> center;
  double edge_m = 0.6;
  int max_lens_views = 50;  ///< views per camera for the first estimate of its lens; the final fit uses all
};

/// The minimum number of views per camera.
inline constexpr int kFewestViews = 8;

/// Below these numbers of views, image coverage and shared views, there is a warning. Fewer views make the
/// lens unreliable; a cube in the middle of the image needs at most half of the image.
inline constexpr int kFewViews = 20;
inline constexpr double kPoorCoverage = 0.3;
inline constexpr int kFewShared = 10;

/// The quality of one camera's calibration.
struct CameraQuality {
  int views = 0;           ///< used views
  int shared_views = 0;    ///< used views whose board another camera sees at the same time
  int corners = 0;         ///< used corners
  int dropped = 0;         ///< corners that fit no pose of the board, in used and unused views
  double rms_px = 0;       ///< reprojection error of the used corners
  double coverage = 0;     ///< fraction of the image with corners, in cells of an eighth of its width
  std::string bare_sides;  ///< sides of the image with few corners: "left, top"
  double focal_sigma = 0;  ///< standard deviation of the focal length, relative to it
};

/// The distance between two cameras.
struct Baseline {
  int a = 0, b = 0;
  double metres = 0;
};

/// A used corner and its reprojection error.
struct CornerResidual {
  int camera = 0, frame = 0;
  Vec2 pixel = Vec2::Zero();
  Vec2 error_px = Vec2::Zero();  ///< observed - projected
};

struct Calibration {
  Rig rig;
  std::vector<CameraQuality> cameras;
  double rms_px = 0;  ///< over all cameras' corners
  /// RMS error of the distances between a board's corners triangulated by at least two cameras, mm; empty if
  /// no two cameras see the same corner.
  std::optional<double> scale_error_mm;
  std::vector<Baseline> baselines;
  int world_frame = 0;
  std::vector<Pose> world_from_boards;  ///< one board pose per frame on which several cameras agree
  std::vector<CornerResidual> residuals;
  std::vector<std::string> warnings;  ///< one line each: camera, problem, and remedy
};

/// Calibrates a rig; calls reportProgress(). \pre the views' ids are those of the board
/// \throw Error naming the camera and the remedy if there are fewer than two cameras, a camera has too few
/// views or no lens fits them, no chain of shared views connects all cameras, or the world frame shows no
/// board.
Calibration calibrate(const Board& board, const std::vector<CameraViews>& cameras,
                      const CalibrationOptions& options = {});

/// Draws the rig from above and from the side with the boards, and each camera's residuals, magnified 100
/// times. \throw Error if the file cannot be written.
void drawCalibration(const std::filesystem::path& png, const Board& board, const Calibration& calibration);

}  // namespace airclay
