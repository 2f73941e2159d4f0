// SPDX-License-Identifier: MIT
// The main job: a recording's hand sculpts clay, and what comes of it is left in a folder.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "app/cli/command.h"
#include "app/session/session.h"
#include "capture/takes/player.h"
#include "capture/takes/recording.h"
#include "engine/clay/document.h"
#include "engine/hand/hand_model.h"
#include "engine/pipeline.h"

namespace airclay {

struct Sculpting {
  HandModel hand;
  std::optional<TriangleMesh> forearm;         ///< drawn behind the hand
  ClayState clay;                              ///< at the beginning
  std::filesystem::path out;                   ///< a folder that is there
  std::optional<std::filesystem::path> video;  ///< an .mp4
};

/// What is left of a sculpting: surface.obj, cage.obj, poses.tum, before.png, touch.png and workings.png (of
/// the first frame in which the hand touches clay), after.png, and the video; and what it came to in words.
class SculptResults {
 public:
  /// `recording` and `sculpting` must outlive this; no recording: the mouse's hand.
  SculptResults(Gpu& gpu, const Pipeline& pipeline, const Recording* recording, const Sculpting& sculpting);
  ~SculptResults();

  void add(const PlayedFrame& frame);
  /// Writes what is left.
  void finish(const Pipeline& pipeline);
  void printLine(const CommonOptions& options) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Plays the whole recording, or what was recorded, without a window, and leaves its SculptResults; strokes
/// go into `document`. The frames take the window's way, so that both make the same clay.
void sculptHeadless(Gpu& gpu, const Session::Options& options, const Sculpting& sculpting,
                    const SculptControls& controls, Document document, const CommonOptions& common);

}  // namespace airclay
