// SPDX-License-Identifier: MIT
// A recording on disk that is processed quickly.
#pragma once

#include <filesystem>

#include "engine/synthetic/script.h"

namespace airclay {

struct SmallTake {
  int empty_frames = 10;  ///< of the empty workspace, at the start
  double slower = 1;      ///< factor of the duration of the hand's motion
  std::vector<Vec3> way;  ///< waypoints in metres, half a second each, from the initial position;
                          ///< empty: the default path
};

/// The hand's motion: it approaches the tube's side, presses it in and leaves.
HandScript smallTakeScript(const SmallTake& take = {});

/// Writes a few small images at 30 Hz. Returns the number of frames.
int writeSmallTake(const std::filesystem::path& folder, const SmallTake& take = {});

}  // namespace airclay
