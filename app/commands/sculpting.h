// SPDX-License-Identifier: MIT
// Sculpts with the hand of a recording, and writes the results to a folder.
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
  ClayState clay;                              ///< at the start
  std::filesystem::path out;                   ///< an existing folder
  std::optional<std::filesystem::path> video;  ///< an .mp4
};

/// The results of sculpting: surface.obj, cage.obj, poses.tum, before.png, touch.png and workings.png (of the
/// first frame in which the hand touches clay), after.png, the video, and a text summary.
class SculptResults {
 public:
  /// `recording` and `sculpting` must outlive this; a null recording means the mouse hand.
  SculptResults(Gpu& gpu, Pipeline& pipeline, const Recording* recording, const Sculpting& sculpting);
  ~SculptResults();

  void add(const PlayedFrame& frame);
  /// Writes the remaining files.
  void finish(Pipeline& pipeline);
  void printLine(const CommonOptions& options) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Plays or replays the whole recording without a window and writes its SculptResults; strokes go into
/// `document`. Frames go through Session, as in the window, so that both make the same clay.
void sculptHeadless(Gpu& gpu, const Session::Options& options, const Sculpting& sculpting,
                    const SculptControls& controls, Document document, const CommonOptions& common);

}  // namespace airclay
