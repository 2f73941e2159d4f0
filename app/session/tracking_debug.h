// SPDX-License-Identifier: MIT
// Images that show what tracking sees: each camera's image with the fitted hand, next to the evidence for the
// hand.
#pragma once

#include <filesystem>
#include <memory>

#include "app/session/images.h"
#include "capture/images/video_writer.h"
#include "capture/takes/player.h"
#include "engine/hand/outline.h"

namespace airclay {

/// A camera's image with the outline of the silhouette (yellow) and of the fitted hand, in the colour of its
/// state: green tracked, orange uncertain, red lost.
/// `mask`: the camera's silhouette.
RgbaImage trackingOverlay(const Pipeline& pipeline, std::size_t camera, const Silhouette& mask,
                          const OutlineModel& model, const FrameResult& result);
/// The camera's evidence: white for the hand, black against it, grey where it says nothing or was not needed.
/// `words`: the evidence of all cameras, or empty.
RgbaImage evidenceImage(const Pipeline& pipeline, std::size_t camera, std::span<const std::uint32_t> words);

/// Writes one contact sheet per frame, 000012.png, and all of them as tracking.mp4.
class TrackingDebug {
 public:
  /// \throw Error if the folder cannot be written.
  TrackingDebug(const std::filesystem::path& folder, const HandModel& hand, double rate_hz);
  void add(const Pipeline& pipeline, const PlayedFrame& frame);
  /// Closes the video.
  void finish();

 private:
  std::filesystem::path folder_;
  OutlineModel model_;
  double rate_hz_;
  std::unique_ptr<VideoWriter> video_;
};

}  // namespace airclay
