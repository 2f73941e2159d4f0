// SPDX-License-Identifier: MIT
// Tracks the hand from frame to frame: from the last pose if there is one, otherwise by a search over all
// orientations.
//
// On the first frame the paper places the model's centre of mass on the voxel model's. The orientation is
// unknown then, and the published iteration gets stuck if it starts more than 15° off; so the search starts
// it from orientations all around, coarse to fine. A forearm in the image shifts the voxel model's centre of
// mass along the arm; so the search also starts at positions along the voxel model's long axis.
#pragma once

#include "engine/hand/fit.h"
#include "engine/mesh/distance_grid.h"

namespace airclay {

class HandTracker {
 public:
  HandTracker(Gpu& gpu, const GpuRig& rig, const HandModel& hand, const Carver& carver);

  /// Whether there is a pose to start from.
  bool hasPose() const { return has_pose_; }
  void forget() { has_pose_ = false; }

  /// Records the fit from the last pose and from its extrapolation, after the carving in the same submission.
  /// \pre hasPose()
  void recordTracking(Recorder& recorder);
  /// Searches the carved model, with separate submissions, and keeps the best pose as the next start. False
  /// if nothing could be a hand. Adds the stage times of its submissions to `stage_ms`.
  bool search(Recorder& recorder, StageTimes& stage_ms);

  /// The hands on the device: element k is hand k, up to kMaxHands. Currently only the first is tracked.
  const Buffer<GpuHandPose>& hands() const { return hands_; }
  /// Reads the result of the finished submission; it becomes the last pose if it is plausible, otherwise the
  /// hand is forgotten.
  HandFit finish();
  /// Whether the voxel model is too small to be a hand. \pre the carving is done
  bool isEmpty() const;

  const FitModel& model() const { return fitter_.model(); }

 private:
  struct Candidate {
    GpuFit fit;
    double uncovered = 0;
  };
  std::vector<Vec3> occupiedCells(const FieldGrid& grid) const;
  std::vector<Candidate> fitAll(Recorder& recorder, Fitter& fitter, const FieldGrid& grid,
                                const std::vector<GpuFit>& starts, int iterations, StageTimes& stage_ms);
  void selectBest(std::vector<Candidate>& candidates, const std::vector<Vec3>& cells, double cell_m,
                  std::size_t count) const;
  static std::vector<GpuFit> starts(const std::vector<Candidate>& candidates);
  std::vector<GpuFit> searchStarts(const std::vector<Vec3>& cells) const;
  void recordField(Recorder& recorder, const FieldGrid& grid, StageTimes& stage_ms);
  double uncovered(const GpuFit& fit, const std::vector<Vec3>& cells, double cell_m) const;
  FitChooseArgs chooseArgs(std::uint32_t count, double cell_m) const;

  Gpu& gpu_;
  const GpuRig& rig_;
  const Carver& carver_;
  Fitter fitter_, coarse_fitter_;
  Kernel<FitChooseArgs> choose_;
  DistanceField field_;
  DistanceGrid hand_distance_;  ///< distance to the skin, hand frame
  Vec3 hand_low_, hand_high_;   ///< the skin's bounding box, hand frame
  Buffer<GpuFit> fits_, result_;
  Buffer<GpuHandPose> hands_;
  std::uint32_t min_occupied_ = 0;
  bool has_pose_ = false;
  GpuFit last_{}, before_last_{};
  int frames_ = 0;  ///< consecutively tracked frames; two define a motion
};

/// The cells around the skin at a pose, with a margin for the hand's motion between two frames.
FieldGrid gridAround(const Carver& carver, const FitModel& model, const GpuHandPose& pose);

/// `count` rotations evenly distributed over SO(3) (Alexa 2022, "Super-Fibonacci Spirals: Fast,
/// Low-Discrepancy Sampling of SO(3)").
std::vector<Eigen::Quaterniond> uniformRotations(int count);

}  // namespace airclay
