// SPDX-License-Identifier: MIT
// The main job: a recording's hand sculpts clay, and what comes of it is left in a folder.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "app/command.h"
#include "app/player.h"
#include "capture/recording.h"
#include "engine/document.h"
#include "engine/hand_model.h"
#include "engine/pipeline.h"

namespace airclay {

struct Sculpting {
  HandModel hand;
  std::optional<TriangleMesh> forearm;  ///< drawn behind the hand
  ClayOptions clay;
  SculptControls controls;
  std::filesystem::path out;                   ///< a folder that is there
  std::optional<std::filesystem::path> video;  ///< an .mp4
};

/// What is left of a sculpting: surface.obj, cage.obj, poses.tum, before.png, touch.png and workings.png (of
/// the first frame in which the hand touches clay), after.png, and the video; and what it came to in words.
class SculptResults {
 public:
  /// `pipeline`, `recording` and `sculpting` must outlive this.
  SculptResults(Gpu& gpu, const Pipeline& pipeline, const Recording& recording, const Sculpting& sculpting);
  ~SculptResults();

  void add(const PlayedFrame& frame);
  /// Writes what is left, and says it.
  void finish(const CommonOptions& options);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Plays the whole recording without a window, and leaves its SculptResults; strokes go into `document`, if
/// any.
void sculptHeadless(Gpu& gpu, Recording& recording, const Sculpting& sculpting, Document* document,
                    const CommonOptions& options);

}  // namespace airclay
