// SPDX-License-Identifier: MIT
// A recording on disk that is quickly worked through.
#pragma once

#include <filesystem>

#include "engine/synthetic/script.h"

namespace airclay {

struct SmallTake {
  int empty_frames = 10;  ///< of the empty workspace, at the start
  double slower = 1;      ///< the hand takes so many times longer for its way
  std::vector<Vec3> way;  ///< metres: it goes by these places, from where it began, half a second to each;
                          ///< none: its usual way
};

/// What the hand does in it: it comes to the tube's side, presses it in and goes away.
HandScript smallTakeScript(const SmallTake& take = {});

/// The recording: small images, 30 a second, few. Returns how many frames.
int writeSmallTake(const std::filesystem::path& folder, const SmallTake& take = {});

}  // namespace airclay
