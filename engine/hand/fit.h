// SPDX-License-Identifier: MIT
// Hand pose estimation (section 2 of the paper): the skeletal model is pushed into the voxel model by forces
// on the patches that stick out.
//
// Positions here are in the workspace's frame (the world moved to the workspace's centre) unless a name says
// otherwise.
#pragma once

#include "engine/hand/hand_model.h"
#include "engine/hand/hand_pose.h"
#include "engine/hull/distance.h"
#include "shaders/hand/fit_io.h"

namespace airclay {

/// How a fit ended.
enum class FitOutcome {
  kIncluded = kFitIncluded,                ///< no patch is outside the voxel model any more
  kStalled = kFitStalled,                  ///< the steps became too small to matter
  kOutOfIterations = kFitOutOfIterations,  ///< still moving at the iteration limit
};

/// A hand that was found in the voxel model.
struct HandFit {
  HandPose pose;
  FitOutcome outcome = FitOutcome::kOutOfIterations;
  int iterations = 0;
  double outside_m = 0;         ///< how far outside the patches are on average, by area
  double outside_fraction = 1;  ///< share of the skin's patches that are outside the voxel model
  bool tracked = false;         ///< believable: the voxel model explains the hand
};

/// What the fit needs of a hand model: patches about the centre of gravity of the solid hand.
struct FitModel {
  std::vector<GpuPatch> patches;
  Vec3 center_of_mass = Vec3::Zero();  ///< in the hand's frame, metres: the volume's centroid
  Mat3 inertia_m2 = Mat3::Zero();      ///< about it, over the mass
  double patch_area_m2 = 0;            ///< of all patches
  double radius_m = 0;                 ///< of the ball about the centre of gravity that holds the skin
};

FitModel fitModel(const HandModel& hand);

/// Every `step`-th patch, with the areas scaled so that their sum stays: for the coarse search.
FitModel thinned(const FitModel& model, int step);

/// The margin of the force law, as a share of a cell: patches are pushed from this far inside the surface, so
/// that opposite sides of the hand balance each other within the voxels' rounding.
inline constexpr double kFitMargin = 0.25;

struct FitLimits {
  int iterations = 40;
};

/// The twin of the kernel: one hypothesis, serial, in double precision. `start` and the result are as in
/// GpuFit.
GpuFit fitReference(const FitModel& model, const std::vector<double>& field, const FieldGrid& grid,
                    const GpuFit& start, const FitLimits& limits);

/// What the poses of fits refer to.
HandPoseFrame poseFrame(const FitModel& model, const Workspace& workspace);
/// A start at a pose.
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
