// SPDX-License-Identifier: MIT
// A recording on disk that is quickly worked through.
#pragma once

#include <filesystem>

namespace airclay {

/// A recording of a hand that comes to the tube's side, presses it in and goes away: small pictures, few, ten
/// of the empty workspace before them. Returns how many frames.
int writeSmallTake(const std::filesystem::path& folder);

}  // namespace airclay
