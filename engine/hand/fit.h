// SPDX-License-Identifier: MIT
// Hand pose estimation (section 2 of the paper): forces on the patches that are outside push the skeletal
// model into the voxel model.
//
// Positions are in the workspace frame (the world frame moved to the workspace's centre) unless their name
// says otherwise.
#pragma once

#include "engine/hand/hand_model.h"
#include "engine/hand/hand_pose.h"
#include "engine/hull/distance.h"
#include "shaders/hand/fit_io.h"

namespace airclay {

/// The reason why a fit ended.
enum class FitOutcome {
  kIncluded = kFitIncluded,                ///< no patch is outside the voxel model
  kStalled = kFitStalled,                  ///< the steps became negligible
  kOutOfIterations = kFitOutOfIterations,  ///< still moving at the iteration limit
};

/// A hand fitted to the voxel model.
struct HandFit {
  HandPose pose;
  FitOutcome outcome = FitOutcome::kOutOfIterations;
  int iterations = 0;
  double outside_m = 0;         ///< mean distance of the patches outside the voxel model, weighted by area
  double outside_fraction = 1;  ///< fraction of the skin's patches that are outside the voxel model
  bool tracked = false;         ///< the pose is plausible
  bool uncertain = false;       ///< tracked, but not to be trusted for sculpting
  double agreement = 0;         ///< fraction of the outline that the images confirm (robust fit)
  double scale = 1;             ///< of the hand relative to its model
  /// Of the centre of mass in metres and a rotation vector in radians, world axes (robust fit, otherwise 0).
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
};

/// A hand model for the fit: patches relative to the centre of mass of the solid hand.
struct FitModel {
  std::vector<GpuPatch> patches;
  Vec3 center_of_mass = Vec3::Zero();  ///< hand frame, metres: the volume's centroid
  Mat3 inertia_m2 = Mat3::Zero();      ///< about the centre of mass, divided by the mass
  double patch_area_m2 = 0;            ///< of all patches
  double radius_m = 0;                 ///< largest distance of the skin from the centre of mass
};

FitModel fitModel(const HandModel& hand);

/// Every `step`-th patch, with areas scaled to the same sum, for the coarse search.
FitModel thinned(const FitModel& model, int step);

/// The margin of the force law, as a fraction of a cell: forces act from this far inside the surface, so that
/// opposite sides of the hand balance each other within the voxels' rounding.
inline constexpr double kFitMargin = 0.25;

struct FitLimits {
  int iterations = 40;
};

/// The reference implementation of the kernel: one hypothesis, serial, in double precision. `start` and the
/// result are as in GpuFit.
GpuFit fitReference(const FitModel& model, const std::vector<double>& field, const FieldGrid& grid,
                    const GpuFit& start, const FitLimits& limits);

/// The frame of the poses in GpuFit.
HandPoseFrame poseFrame(const FitModel& model, const Workspace& workspace);
/// A fit that starts at the given pose.
GpuFit fitAt(const HandPose& start, const FitModel& model, const Workspace& workspace);

/// A batch of hypotheses on the device.
class Fitter {
 public:
  Fitter(Gpu& gpu, const FitModel& model);
  /// Records the fit of the first `count` of `fits`, all iterations, one workgroup each.
  void record(Recorder& recorder, const DistanceField& field, const FieldGrid& grid,
              const Buffer<GpuFit>& fits, std::uint32_t count, const FitLimits& limits);
  const FitModel& model() const { return model_; }

 private:
  FitModel model_;
  Kernel<FitArgs> kernel_;
  Buffer<GpuPatch> patches_;
};

}  // namespace airclay
