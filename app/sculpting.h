// SPDX-License-Identifier: MIT
// The main job: a recording's hand sculpts clay, and what comes of it is left in a folder.
#pragma once

#include <filesystem>
#include <optional>

#include "app/command.h"
#include "capture/recording.h"
#include "engine/hand_model.h"
#include "engine/pipeline.h"

namespace airclay {

struct Sculpting {
  HandModel hand;
  std::optional<TriangleMesh> forearm;  ///< drawn behind the hand
  ClayOptions clay;
  std::filesystem::path out;                   ///< a folder that is there
  std::optional<std::filesystem::path> video;  ///< an .mp4
};

/// Plays the whole recording. Leaves surface.obj, cage.obj, poses.tum, before.png, touch.png and workings.png
/// (of the first frame in which the hand touches clay), after.png, and the video; says what it came to.
void sculpt(Gpu& gpu, Recording& recording, const Sculpting& sculpting, const CommonOptions& options);

}  // namespace airclay
