// SPDX-License-Identifier: MIT
// A recording on disk that is quickly worked through.
#pragma once

#include <filesystem>

#include "engine/script.h"

namespace airclay {

/// What the hand does in it: it comes to the tube's side, presses it in and goes away.
HandScript smallTakeScript(int empty_frames = 10);

/// The recording: small pictures, 30 a second, few, those of the empty workspace before them. Returns how
/// many frames.
int writeSmallTake(const std::filesystem::path& folder, int empty_frames = 10);

}  // namespace airclay
