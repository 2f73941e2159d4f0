// SPDX-License-Identifier: MIT
// Where the hand is, frame after frame: from the last pose while there is one, by a search over all
// orientations while there is none.
//
// On the first frame the paper starts with the model's centre of gravity on the voxel model's. The
// orientation is unknown then, and the published iteration alone gets stuck from 15° off; so it is started
// from orientations all around, coarse to fine. A forearm in the image draws the voxel model's centre of
// gravity along the arm; so it is started along the voxel model's long axis, too.
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

  /// Records the fit from the last pose and its continuation, after the carving in the same submission. \pre
  /// hasPose()
  void recordTracking(Recorder& recorder);
  /// Searches the carved model, with submissions of its own, and leaves the best pose as the one to start
  /// from. False when nothing there could be a hand. Stage times of its submissions are added to `stage_ms`.
  bool search(Recorder& recorder, StageTimes& stage_ms);

  /// The hands on the device: element k is hand k, up to kMaxHands. So far only the first is tracked.
  const Buffer<GpuHandPose>& hands() const { return hands_; }
  /// Takes the result of the finished submission as the last pose when it is believable, forgets the hand
  /// when it is not.
  HandFit finish();
  /// \pre the carving is done
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
  void keepBest(std::vector<Candidate>& candidates, const std::vector<Vec3>& cells, double cell_m,
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
  DistanceGrid hand_distance_;  ///< hand frame: how far a cell is from the hand
  Vec3 hand_low_, hand_high_;   ///< the skin's box, hand frame about the centre of gravity
  Buffer<GpuFit> fits_, result_;
  Buffer<GpuHandPose> hands_;
  std::uint32_t min_occupied_ = 0;
  bool has_pose_ = false;
  GpuFit last_{}, before_last_{};
  int frames_ = 0;  ///< finished in a row: the last two make a motion
};

/// The cells around the skin in that pose, and as far as a hand moves between two frames.
FieldGrid gridAround(const Carver& carver, const FitModel& model, const GpuHandPose& pose);

/// `count` rotations spread evenly over all (Alexa 2022, "Super-Fibonacci Spirals: Fast, Low-Discrepancy
/// Sampling of SO(3)").
std::vector<Eigen::Quaterniond> spreadRotations(int count);

}  // namespace airclay
