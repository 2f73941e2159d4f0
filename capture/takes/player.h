// SPDX-License-Identifier: MIT
// Runs a recording through the pipeline, frame by frame.
#pragma once

#include <optional>

#include "capture/takes/recording.h"
#include "engine/pipeline.h"

namespace airclay {

/// A frame and its result.
struct PlayedFrame {
  int frame = 0;
  double time_s = 0;
  bool background = false;       ///< used to learn the empty workspace; the hand is kEmpty
  double decode_ms = 0;          ///< from file to pixels in memory
  std::optional<double> skew_s;  ///< between the cameras; empty without per-camera timestamps
  FrameResult result;
};

/// Plays a recording: its background first, then every frame in order.
class Player {
 public:
  /// \throw Error if the recording has no frames after those of the empty workspace.
  Player(Recording& recording, Pipeline& pipeline);

  /// Processes the next frame; empty after the last one.
  std::optional<PlayedFrame> next(const SculptControls& controls = {});
  /// Computes only silhouettes and hull of one frame. \throw Error if the recording has no such frame.
  void computeHull(int frame);

 private:
  void readFrame(int frame);
  void learnFromBackgroundImages();

  Recording& recording_;
  Pipeline& pipeline_;
  std::vector<std::span<std::uint8_t>> buffers_;  ///< the pipeline's images, or masks_
  std::vector<Silhouette> masks_;
  int next_ = 0;
};

}  // namespace airclay
