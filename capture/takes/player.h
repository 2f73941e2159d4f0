// SPDX-License-Identifier: MIT
// A recording through the pipeline, frame by frame.
#pragma once

#include <optional>

#include "capture/takes/recording.h"
#include "engine/pipeline.h"

namespace airclay {

/// A frame and what became of it.
struct PlayedFrame {
  int frame = 0;
  double time_s = 0;
  bool background = false;       ///< it taught the empty workspace: the hand is kEmpty
  double decode_ms = 0;          ///< file to pixels in memory
  std::optional<double> skew_s;  ///< the cameras'; none without times of their own
  FrameResult result;
};

/// Plays a recording: its background first, then every frame in order.
class Player {
 public:
  /// \throw Error when the recording has no more frames than the empty workspace takes.
  Player(Recording& recording, Pipeline& pipeline);

  /// None past the last frame.
  std::optional<PlayedFrame> next(const SculptControls& controls = {});
  /// Silhouettes and hull alone, of one frame. \throw Error when the recording has no such frame.
  void hullOf(int frame);

 private:
  void readFrame(int frame);
  void learnFromBackgroundImages();

  Recording& recording_;
  Pipeline& pipeline_;
  std::vector<std::span<std::uint8_t>> buffers_;  ///< the pipeline's images, or masks_
  std::vector<Mask> masks_;
  int next_ = 0;
};

}  // namespace airclay
