// SPDX-License-Identifier: MIT
// What the parts of the calibration hand to each other; not for others.
#pragma once

#include <limits>

#include "capture/calibration/calibration.h"

namespace airclay {

/// Which of a lens' eight distortion coefficients are sought; the others are 0.
using FreeCoefficients = std::array<bool, 8>;

struct BundleCamera {
  Lens lens;
  FreeCoefficients free{};
  bool free_center = true;  ///< the principal point is sought, too
  Pose camera_from_world = Pose::Identity();
  double noise_px = 1;            ///< standard deviation of a corner's coordinate
  double half_diagonal_px = 400;  ///< of the image
};

/// One camera's view of one board. Views of one instant share a stand.
struct BundleView {
  int camera = 0, frame = 0;
  int stand = 0;  ///< place in Bundle::world_from_board
  std::vector<int> ids;
  std::vector<Vec3> corners;  ///< board, metres
  std::vector<Vec2> pixels;
  std::vector<char> trusted;  ///< whether the corner counts

  int trustedCount() const;
};

/// Everything that is adjusted at once.
struct Bundle {
  std::vector<BundleCamera> cameras;
  std::vector<Pose> world_from_board;
  std::vector<BundleView> views;
};

enum class Loss { kCauchy, kHuber };

struct AdjustOptions {
  Loss loss = Loss::kCauchy;
  double loss_scale = 2.4;  ///< in standard deviations: 95 % efficient for Cauchy's (Rey 1983)
  /// Hold all of them; the first camera is held where no stand is.
  bool fix_lenses = false, fix_cameras = false, fix_stands = false;
  int max_iterations = 60;
  double done = 0;  ///< share of the calibration that lies behind, for reportProgress()
};

/// Least squares over all trusted corners, the first camera's pose held. \throw Error when it diverges.
void adjust(Bundle& bundle, const AdjustOptions& options = {});

/// seen - projected in pixels; a corner that cannot be projected is 1e6 px off.
Vec2 residualOf(const Bundle& bundle, const BundleView& view, std::size_t corner);
std::vector<double> residualLengths(const Bundle& bundle, const BundleView& view);

/// Standard deviation of a coordinate of the trusted residuals of a camera, by their median: half the corners
/// may be wrong.
double robustNoise(const Bundle& bundle, int camera);

/// Sum over trusted corners of Cauchy's loss in units of `noise_px`², twice the negative log likelihood.
double robustCost(const Bundle& bundle, double noise_px);

/// The relative standard deviation of each camera's focal length.
std::vector<double> focalSigmas(const Bundle& bundle);

/// How surely a camera's pose is known.
struct PoseSigma {
  double place_m = std::numeric_limits<double>::infinity();  ///< of the world's origin, as the camera sees it
  double turn = std::numeric_limits<double>::infinity();     ///< radians
};

/// The standard deviations of each camera's pose, by its own views of boards that are taken to be known.
std::vector<PoseSigma> poseSigmas(const Bundle& bundle);

/// A corner counts as long as it is this near, for a camera of this noise.
double trustedRadius(double noise_px);

/// Trusts the corners that are near enough, and no others.
void trustNearCorners(Bundle& bundle);

/// The two poses camera_from_board that a flat board's view allows (Collins and Bartoli 2014, "Infinitesimal
/// plane-based pose estimation"), the likelier first; none where the corners determine none.
std::vector<Pose> boardPoses(const Lens& lens, const BundleView& view);

/// The view's corners that lie on two rows and two columns or more; none where there are fewer than 6
/// corners.
std::optional<BundleView> usableView(const Board& board, const BoardView& view);

/// Whose lens is sought, from which of its views.
struct LensTask {
  const CameraViews& camera;
  std::vector<BundleView> views;
  double done = 0;  ///< as in AdjustOptions
};

/// Whether light arrives at the whole of an image of width x height pixels: the model does not turn before
/// its corners (or 85 degrees from the axis, where a fisheye lens may end).
bool reachesCorners(const Lens& lens, int width, int height);

/// One camera's lens. \throw Error naming the camera when no lens explains the views.
BundleCamera fitLens(const LensTask& task, const CalibrationOptions& options);

/// Both poses of each view's board, in the order of the views.
using ViewPoses = std::vector<std::vector<Pose>>;

/// Where the cameras stand, through the boards that two of them saw at once; the first camera's is the world.
/// \throw Error naming cameras that no chain of shared views connects.
void chainCameras(Bundle& bundle, const ViewPoses& poses, const std::vector<CameraViews>& names);

/// What reportProgress() is told: finding the lenses takes half of the time.
inline constexpr double kLensesShare = 0.5;

/// How many good views of the board each camera needs, and how many would be better.
struct ViewsNeeded {
  int fewest, better;
};

/// The views that can be used, camera by camera, those of one frame at one stand; cameras are still to be
/// added. \throw Error naming a camera with too few.
Bundle gatherViews(const Board& board, const std::vector<CameraViews>& cameras, const ViewsNeeded& needed);

/// Finds where the cameras and the boards are, from the lenses alone: chains the cameras, then adjusts
/// everything, trusts the corners that fit, and gives views that contradict others stands of their own.
/// \throw Error naming cameras that nothing connects.
void placeAll(Bundle& bundle, const std::vector<CameraViews>& cameras, bool fix_lenses);

/// How many cameras have a trusted view of each stand.
std::vector<int> sharersOfStands(const Bundle& bundle);

/// How many of each camera's trusted views are of boards that another camera saw at the same time.
std::vector<int> sharedViews(const Bundle& bundle);

/// A view of the board that the world is to lie on: that of the named frame, or of the first of those that
/// most cameras see best. \throw Error when no camera sees it in the named one.
const BundleView& worldView(const Bundle& bundle, std::optional<int> frame);

/// Moves everything into the world in which the board of `view` lies: origin in its middle, x along its rows,
/// z out of its face.
void placeWorld(Bundle& bundle, const BundleView& view, const Board& board);

/// How good it is: everything of Calibration but the rig, the world and the warnings.
/// \pre calibration.rig is the bundle's
void measure(const Bundle& bundle, Calibration& calibration);

/// Warns of cameras that don't take their images at the same time.
void warnOfSkew(const Bundle& bundle, std::vector<std::string>& warnings);

/// What a camera's corners are off by where something is wrong: what good webcams and a flat board reach is
/// half of this.
inline constexpr double kHighRms_px = 0.7;

/// measure(), the lenses' certainty, and the warnings of a new calibration.
void report(const Bundle& bundle, Calibration& calibration);

}  // namespace airclay
