// SPDX-License-Identifier: MIT
// Internal interfaces between the parts of the calibration.
#pragma once

#include <limits>

#include "capture/calibration/calibration.h"

namespace airclay {

/// Which of a lens's eight distortion coefficients are free; the others are 0.
using FreeCoefficients = std::array<bool, 8>;

struct BundleCamera {
  Lens lens;
  FreeCoefficients free{};
  bool free_center = true;  ///< the principal point is free too
  Pose camera_from_world = Pose::Identity();
  double noise_px = 1;            ///< standard deviation of a corner's coordinate
  double half_diagonal_px = 400;  ///< of the image
};

/// One camera's view of one board. Views of the same instant have the same stand.
struct BundleView {
  int camera = 0, frame = 0;
  int stand = 0;  ///< index in Bundle::world_from_board
  std::vector<int> ids;
  std::vector<Vec3> corners;  ///< board, metres
  std::vector<Vec2> pixels;
  std::vector<char> trusted;  ///< whether the corner is used

  int trustedCount() const;
};

/// All parameters of the joint adjustment.
struct Bundle {
  std::vector<BundleCamera> cameras;
  std::vector<Pose> world_from_board;
  std::vector<BundleView> views;
};

enum class Loss { kCauchy, kHuber };

struct AdjustOptions {
  Loss loss = Loss::kCauchy;
  double loss_scale = 2.4;  ///< in standard deviations: 95 % efficient for Cauchy's (Rey 1983)
  /// Keep all of them constant. The first camera is constant unless the stands are.
  bool fix_lenses = false, fix_cameras = false, fix_stands = false;
  int max_iterations = 60;
  double done = 0;  ///< completed fraction of the calibration, for reportProgress()
};

/// Least squares over all trusted corners. \throw Error if it diverges.
void adjust(Bundle& bundle, const AdjustOptions& options = {});

/// observed - projected, pixels; 1e6 for a corner that cannot be projected.
Vec2 residualOf(const Bundle& bundle, const BundleView& view, std::size_t corner);
std::vector<double> residualLengths(const Bundle& bundle, const BundleView& view);

/// Standard deviation of a coordinate of a camera's trusted residuals, from their median, so that up to half
/// of the corners may be wrong.
double robustNoise(const Bundle& bundle, int camera);

/// The sum of Cauchy's loss over trusted corners in units of `noise_px`²: twice the negative log-likelihood.
double robustCost(const Bundle& bundle, double noise_px);

/// The relative standard deviation of each camera's focal length.
std::vector<double> focalSigmas(const Bundle& bundle);

/// The uncertainty of a camera's pose: standard deviations.
struct PoseSigma {
  double place_m = std::numeric_limits<double>::infinity();  ///< of the world's origin in the camera frame
  double turn = std::numeric_limits<double>::infinity();     ///< radians
};

/// The uncertainty of each camera's pose, from its own views and with the boards assumed known.
std::vector<PoseSigma> poseSigmas(const Bundle& bundle);

/// The largest residual of a trusted corner for a camera with this noise, pixels.
double trustedRadius(double noise_px);

/// Trusts exactly the corners within trustedRadius().
void trustNearCorners(Bundle& bundle);

/// The two poses camera_from_board that a flat board's view allows (Collins and Bartoli 2014, "Infinitesimal
/// plane-based pose estimation"), the more likely one first; empty if the corners determine none.
std::vector<Pose> boardPoses(const Lens& lens, const BundleView& view);

/// Converts a view; empty if it has fewer than 6 corners, or corners in only one row or column.
std::optional<BundleView> usableView(const Board& board, const BoardView& view);

/// A camera whose lens is to be estimated, and its views.
struct LensTask {
  const CameraViews& camera;
  std::vector<BundleView> views;
  double done = 0;  ///< like AdjustOptions::done
};

/// Whether every pixel of an image of width x height pixels has a ray: the model is monotonic up to the
/// image's corners (or 85 degrees from the axis, where a fisheye lens may end).
bool reachesCorners(const Lens& lens, int width, int height);

/// Estimates one camera's lens. \throw Error naming the camera if no lens fits the views.
BundleCamera fitLens(const LensTask& task, const CalibrationOptions& options);

/// Both board poses of each view, in the order of the views.
using ViewPoses = std::vector<std::vector<Pose>>;

/// Estimates the cameras' poses from boards that two of them see at the same time; the first camera is the
/// world. \throw Error naming cameras that no chain of shared views connects.
void chainCameras(Bundle& bundle, const ViewPoses& poses, const std::vector<CameraViews>& names);

/// The fraction of the time that lens estimation takes, for reportProgress().
inline constexpr double kLensesShare = 0.5;

/// The minimum and the recommended number of good views per camera.
struct ViewsNeeded {
  int fewest, better;
};

/// The usable views by camera, with one stand per frame; cameras are added later. \throw Error naming a
/// camera with too few views.
Bundle gatherViews(const Board& board, const std::vector<CameraViews>& cameras, const ViewsNeeded& needed);

/// \throw Error naming the camera that shows the board smallest and the size that is needed, if that is too
/// small. Called when a calibration fails, because inaccurate corners are then the likely cause.
void checkBoardSize(const Board& board, const std::vector<CameraViews>& cameras);

/// Estimates the poses of cameras and boards, given the lenses: chains the cameras, adjusts everything,
/// trusts the corners that fit, and gives contradictory views separate stands. \throw Error naming cameras
/// that are not connected.
void placeAll(Bundle& bundle, const std::vector<CameraViews>& cameras, bool fix_lenses);

/// The number of cameras with a trusted view of each stand.
std::vector<int> sharersOfStands(const Bundle& bundle);

/// The number of each camera's trusted views whose board another camera sees at the same time.
std::vector<int> sharedViews(const Bundle& bundle);

/// A view of the board that defines the world: in the given frame, or in the first of the frames that most
/// cameras see best. \throw Error if no camera sees the board in the given frame.
const BundleView& worldView(const Bundle& bundle, std::optional<int> frame);

/// Transforms everything to the world defined by the board of `view`: origin at its centre, x along its rows,
/// z out of its face.
void placeWorld(Bundle& bundle, const BundleView& view, const Board& board);

/// Computes the quality: all fields of Calibration except the rig, the world and the warnings. \pre
/// calibration.rig has the bundle's values
void measure(const Bundle& bundle, Calibration& calibration);

/// Warns about cameras that do not capture at the same time.
void warnOfSkew(const Bundle& bundle, std::vector<std::string>& warnings);

/// The reprojection error above which something is wrong; good webcams and a flat board reach half of this.
inline constexpr double kMaxGoodRms_px = 0.7;

/// measure(), the uncertainty of the lenses, and the warnings of a new calibration.
void report(const Bundle& bundle, Calibration& calibration);

}  // namespace airclay
