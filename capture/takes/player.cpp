// SPDX-License-Identifier: MIT
#include "capture/takes/player.h"

#include "engine/core/clock.h"
#include "engine/core/error.h"

namespace airclay {

Player::Player(Recording& recording, Pipeline& pipeline) : recording_(recording), pipeline_(pipeline) {
  const std::vector<Camera>& cameras = recording_.rig().cameras;
  if (recording_.hasSilhouettes()) {
    for (const Camera& camera : cameras) masks_.push_back(emptySilhouette(camera));
    for (Silhouette& mask : masks_) buffers_.emplace_back(mask.pixels);
    return;
  }
  for (std::size_t i = 0; i < cameras.size(); ++i) buffers_.push_back(pipeline_.image(i));
  if (recording_.backgroundFrames() >= recording_.frameCount())
    throw Error("the recording has " + std::to_string(recording_.frameCount()) + " frames, and the first " +
                std::to_string(recording_.backgroundFrames()) +
                " are assumed to be empty; use a smaller --background or images in background/");
}

void Player::readFrame(int frame) {
  if (recording_.hasSilhouettes())
    recording_.readSilhouettes(frame, buffers_);
  else
    recording_.readImages(frame, buffers_);
}

void Player::learnFromBackgroundImages() {
  if (!recording_.hasBackground() || recording_.hasSilhouettes()) return;
  recording_.readBackground(buffers_);
  pipeline_.learnBackground();
}

std::optional<PlayedFrame> Player::next(const SculptControls& controls) {
  if (next_ == recording_.frameCount()) return std::nullopt;
  if (next_ == 0) learnFromBackgroundImages();
  PlayedFrame played;
  played.frame = next_++;
  played.time_s = recording_.timeOf(played.frame);
  FrameInput input;
  input.camera_times_s = recording_.cameraTimesOf(played.frame);
  played.skew_s = skewOf(input.camera_times_s);
  played.background = played.frame < recording_.backgroundFrames();
  const auto start = Clock::now();
  readFrame(played.frame);
  played.decode_ms = millisecondsSince(start);
  input.missing_cameras = recording_.missingCameras();
  if (played.background)
    pipeline_.learnBackground();
  else
    played.result = recording_.hasSilhouettes() ? pipeline_.processSilhouettes(masks_, controls, input)
                                                : pipeline_.processImages(controls, input);
  return played;
}

void Player::computeHull(int frame) {
  if (frame < 0 || frame >= recording_.frameCount())
    throw Error("the recording has no frame " + std::to_string(frame) + "; expected 0 to " +
                std::to_string(recording_.frameCount() - 1));
  learnFromBackgroundImages();
  for (int i = 0; i < recording_.backgroundFrames(); ++i) {
    readFrame(i);
    pipeline_.learnBackground();
  }
  readFrame(frame);
  FrameInput input;
  input.missing_cameras = recording_.missingCameras();
  if (recording_.hasSilhouettes())
    pipeline_.hullFromSilhouettes(masks_, input);
  else
    pipeline_.hullFromImages(input);
}

}  // namespace airclay
