// SPDX-License-Identifier: MIT
// A hand over a desk in a rendered room (engine/synthetic/room.h) as a recording with true poses.
#pragma once

#include <filesystem>
#include <functional>

#include "capture/takes/recording.h"
#include "capture/takes/truth.h"
#include "engine/synthetic/room.h"

namespace airclay {

/// Equal options give identical bytes, in whatever order frames are read, and on every device.
class RoomRecording : public Recording {
 public:
  explicit RoomRecording(const HandModel& hand, const RoomOptions& options = {});

  const Rig& rig() const override { return options_.rig; }
  int frameCount() const override { return options_.background_frames + options_.hand_frames; }
  double rateHz() const override { return options_.rate_hz; }
  double timeOf(int frame) const override;
  std::vector<double> cameraTimesOf(int frame) const override { return room_.cameraTimesOf(frame); }
  int backgroundFrames() const override { return options_.background_frames; }
  /// Renders on as many threads as there are processors.
  bool readImages(int frame, Buffers bgr) override;
  /// The pose at the frame's time for every frame in which the whole hand is in the cube.
  const std::optional<std::vector<TimedPose>>& truth() const override { return truth_; }

  /// The same, and the hand's motion at 300 Hz, also where it is outside the cube.
  Truth fullTruth() const;

 private:
  RoomOptions options_;
  Room room_;
  std::optional<std::vector<TimedPose>> truth_;
};

/// Renders the recording into a new take: rig.toml, lossless videos, timestamps.csv, truth.tum and
/// truth_dense.tum. `on_frame` is called after each frame. \throw Error if `folder` exists and is not empty,
/// or cannot be written.
void writeTake(RoomRecording& recording, const std::filesystem::path& folder,
               const std::function<void()>& on_frame = {});

}  // namespace airclay
