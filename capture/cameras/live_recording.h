// SPDX-License-Identifier: MIT
// Cameras that run, as something that can be tracked: the newest set of images is the next frame.
#pragma once

#include <atomic>
#include <mutex>

#include "capture/cameras/live_cameras.h"
#include "capture/takes/recording.h"

namespace airclay {

/// The first frames teach the empty workspace, and are complete sets; later a camera may be absent while two
/// others are there.
class LiveRecording : public Recording, private LiveSource {
 public:
  /// `cameras` in the rig's order (inOrderOf). \throw Error naming the camera that cannot be opened, or gives
  /// images of another size than the rig says.
  LiveRecording(const Rig& rig, std::vector<LiveCamera> cameras, const LiveOptions& options,
                int background_frames);

  const Rig& rig() const override { return rig_; }
  /// Those taken, once all sources were files and have ended; before that more than will ever be.
  int frameCount() const override;
  double rateHz() const override { return cameras_.slowestRateHz(); }
  double timeOf(int frame) const override;
  std::vector<double> cameraTimesOf(int frame) const override;
  int backgroundFrames() const override { return background_frames_; }
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
  std::optional<double> first_s_;  ///< the first set's time, on the machine's clock
  double time_s_ = 0;              ///< of the last set, as are those below
  std::vector<double> camera_times_s_;
  std::uint32_t missing_cameras_ = 0;
  std::atomic<int> taken_ = 0;
};

}  // namespace airclay
