// SPDX-License-Identifier: MIT
// Tracks the hand in a real room: finds it from nothing (hand_search.h), follows its outline (outline.h), and
// learns its colours (silhouette/evidence.h). Knows when it is wrong: a pose whose outline the images do not
// confirm is uncertain or lost.
#pragma once

#include "engine/hand/fit.h"
#include "engine/hand/hand_search.h"

namespace airclay {

class RobustTracker {
 public:
  RobustTracker(Gpu& gpu, const GpuRig& rig, const HandModel& hand);

  /// A frame's images with their background, and when they were taken.
  struct Frame {
    const Buffer<std::uint32_t>& images;
    const Buffer<std::uint32_t>& background;  ///< Silhouettes::model()
    bool adapts_background = false;
    std::uint32_t missing_cameras = 0;
    std::span<const double> camera_times_s;  ///< empty: all cameras at the same time
  };

  bool hasPose() const { return has_pose_; }
  void forget();
  /// Forgets the hand, its size and its colours: the next frames give the same as those of a new tracker.
  void reset();
  /// Records the cells' background after the pixels' has changed.
  void recordBackground(Recorder& recorder, const Buffer<std::uint32_t>& model, const CameraRange& cameras);
  /// Records the frame's evidence around the expected hand; then the fit and learning. \pre hasPose()
  void recordEvidence(Recorder& recorder, const Frame& frame);
  void recordTracking(Recorder& recorder, const Frame& frame);
  /// Records the evidence of the whole images, for the hull and the search.
  void recordWholeEvidence(Recorder& recorder, const Frame& frame);
  /// Forgets the hand and its colours.
  void beginSearch();
  /// Searches for the hand, with separate submissions, and keeps the best pose as the next start. False if
  /// nothing could be a hand. Adds the stage times of its submissions to `stage_ms`. \pre beginSearch() was
  /// called and then the evidence of the whole images computed
  bool search(Recorder& recorder, const Frame& frame, StageTimes& stage_ms);
  /// Reads the result of the finished submission; it becomes the last pose unless it is lost.
  HandFit finish();

  /// The hands on the device, for the clay: tracked only if the pose is to be trusted.
  const Buffer<GpuHandPose>& hands() const { return hands_; }
  HandPoseFrame poseFrame(double scale) const;
  Evidence& evidence() { return evidence_; }
  const Evidence& evidence() const { return evidence_; }
  const OutlineFitter& fitter() const { return fitter_; }

 private:
  GpuOutlineFrame outlineFrame(const Frame& frame) const;
  double timeOf(const Frame& frame) const;
  GpuOutlinePose expected(const Frame& frame) const;
  std::vector<GpuTileRegion> regionsAround(const GpuOutlinePose& pose, const GpuOutlineFrame& frame) const;
  void recordFit(Recorder& recorder, const Frame& frame, const GpuOutlinePose& start,
                 std::span<const OutlineStage> stages);

  const GpuRig& rig_;
  OutlineFitter fitter_;
  Evidence evidence_;
  HandSearch search_;
  Kernel<OutlineJudgeArgs> judge_;
  Buffer<GpuHandPose> hands_;
  bool has_pose_ = false;
  GpuOutlinePose last_ = noOutlinePose();
  ScalePrior scale_;      ///< what is known of the hand's size; no weight: it is the model's
  int scale_frames_ = 0;  ///< that contributed
  Vec3 velocity_ = Vec3::Zero(), spin_ = Vec3::Zero();
  double last_time_s_ = 0, frame_time_s_ = 0;
  GpuOutlinePose expected_ = noOutlinePose();  ///< where the last fit started
  double surprise_m_ = 0;                      ///< its largest distance from the result, over the skin
  int frames_ = 0;                             ///< consecutively tracked; two define a motion
  int uncertain_frames_ = 0;
  std::uint32_t next_camera_ = 0;  ///< that learns
  bool was_empty_ = false;         ///< the last search found nothing that could be a hand
  int searches_ = 0;               ///< without success
  int clock_ = 0;                  ///< frames, where they have no times
};

}  // namespace airclay
