// SPDX-License-Identifier: MIT
#include "app/session/player.h"

#include <CLI/CLI.hpp>

#include "app/cli/command.h"
#include "app/session/actions.h"
#include "engine/core/clock.h"
#include "engine/core/error.h"

namespace airclay {

RigUnits parseUnits(const std::string& word) {
  if (word == "m") return RigUnits::kMetres;
  return word == "mm" ? RigUnits::kMillimetres : RigUnits::kAsWritten;
}

void addTakeOptions(CLI::App& command, TakeInputOptions& words) {
  command
      .add_option("TAKE", words.folder, "the recording: a folder with rig.toml and videos, images or masks")
      ->type_name("")
      ->required();
  command.add_option("--units", words.units, "the rig's unit, where its file doesn't say: m or mm")
      ->check(CLI::IsMember({"m", "mm"}).description(""))
      ->type_name("m|mm");
  command
      .add_option("--background", words.background_frames,
                  "how many first frames show the empty workspace, where the take has no background/ [10], "
                  "at most 256")
      ->check(CLI::Range(1, static_cast<int>(kMaxLearnFrames)).description(""))
      ->type_name("N");
}

Take TakeInputOptions::open(const TakeOptions& options) const {
  TakeOptions whole = options;
  whole.units = parseUnits(units);
  whole.background_frames = background_frames;
  whole.unfinished = hasActions(folder);
  Take take(folder, whole);
  if (take.note()) printWarning(*take.note());
  return take;
}

Player::Player(Recording& recording, Pipeline& pipeline) : recording_(recording), pipeline_(pipeline) {
  const std::vector<Camera>& cameras = recording_.rig().cameras;
  if (recording_.hasSilhouettes()) {
    for (const Camera& camera : cameras)
      masks_.push_back({camera.width, camera.height,
                        std::vector<std::uint8_t>(std::size_t(camera.width) * std::size_t(camera.height))});
    for (Mask& mask : masks_) buffers_.emplace_back(mask.pixels);
    return;
  }
  for (std::size_t i = 0; i < cameras.size(); ++i) buffers_.push_back(pipeline_.image(i));
  if (recording_.backgroundFrames() >= recording_.frameCount())
    throw Error("the recording has " + std::to_string(recording_.frameCount()) + " frames, and the first " +
                std::to_string(recording_.backgroundFrames()) +
                " are taken to be empty; a smaller --background or images in background/ would be right");
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
  played.skew_s = skewOf(recording_.cameraTimesOf(played.frame));
  played.background = played.frame < recording_.backgroundFrames();
  const auto start = Clock::now();
  readFrame(played.frame);
  played.decode_ms = millisecondsSince(start);
  if (played.background)
    pipeline_.learnBackground();
  else
    played.result = recording_.hasSilhouettes() ? pipeline_.processMasks(masks_, controls)
                                                : pipeline_.processImages(controls);
  return played;
}

void Player::hullOf(int frame) {
  if (frame < 0 || frame >= recording_.frameCount())
    throw Error("there is no frame " + std::to_string(frame) + " in the recording; its frames are 0 to " +
                std::to_string(recording_.frameCount() - 1));
  learnFromBackgroundImages();
  for (int i = 0; i < recording_.backgroundFrames(); ++i) {
    readFrame(i);
    pipeline_.learnBackground();
  }
  readFrame(frame);
  if (recording_.hasSilhouettes())
    pipeline_.hullFromMasks(masks_);
  else
    pipeline_.hullFromImages();
}

}  // namespace airclay
