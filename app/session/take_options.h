// SPDX-License-Identifier: MIT
// The options of the commands that read a take.
#pragma once

#include <string>

#include "capture/takes/take.h"

namespace CLI {
class App;
}

namespace airclay {

/// What --units says: m, mm, or nothing.
RigUnits parseUnits(const std::string& text);

/// What the commands that read a take ask of it.
struct TakeInputOptions {
  std::string folder, units;
  int background_frames = 10;

  /// Opens the take; what is unusual about it is warned of. One of our own recordings may have been cut off.
  Take open(const TakeOptions& options = {}) const;
};

/// The take itself, --units and --background.
void addTakeOptions(CLI::App& command, TakeInputOptions& options);

}  // namespace airclay
