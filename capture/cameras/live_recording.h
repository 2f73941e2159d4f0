// SPDX-License-Identifier: MIT
// Live cameras as a recording: the newest set of images is the next frame.
#pragma once

#include <atomic>
#include <mutex>

#include "capture/cameras/live_cameras.h"
#include "capture/takes/recording.h"

namespace airclay {

/// The first `background_frames` frames show the empty workspace and are complete sets. Later frames may lack
/// cameras, but have at least two.
class LiveRecording : public Recording, private LiveSource {
 public:
  /// `cameras`: in the rig's order (inOrderOf). \throw Error naming a camera that cannot be opened, or whose
  /// images do not have the rig's size.
  LiveRecording(const Rig& rig, std::vector<LiveCamera> cameras, const LiveOptions& options,
                int background_frames);

  const Rig& rig() const override { return rig_; }
  /// The number of frames read once all sources, being files, have ended; until then the maximum int.
  int frameCount() const override;
  double rateHz() const override { return cameras_.slowestRateHz(); }
  /// Seconds since the first frame, of the last frame that was read, whichever `frame` is; likewise
  /// cameraTimesOf().
  double timeOf(int frame) const override;
  std::vector<double> cameraTimesOf(int frame) const override;
  int backgroundFrames() const override { return background_frames_; }
  /// Waits 0.1 s for the next set. False if none arrives, or a background frame lacks a camera. The image of
  /// a missing camera is black.
  bool readImages(int frame, Buffers bgr) override;
  const std::optional<std::vector<TimedPose>>& truth() const override { return no_truth_; }

  std::uint32_t missingCameras() const override { return missing_cameras_; }
  const LiveSource* live() const override { return this; }

 private:
  std::optional<Clock::time_point> capturedAt() const override;
  std::vector<std::string> cameraProblems() const override;

  Rig rig_;
  LiveCameras cameras_;
  int background_frames_;
  std::optional<std::vector<TimedPose>> no_truth_;
  std::optional<double> first_s_;  ///< the first set's capture time, on the machine's clock
  double time_s_ = 0;              ///< of the last set, like the next two
  std::vector<double> camera_times_s_;
  std::uint32_t missing_cameras_ = 0;
  std::atomic<int> taken_ = 0;
};

}  // namespace airclay
