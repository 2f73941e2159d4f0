// SPDX-License-Identifier: MIT
// The options of the commands that read a take.
#pragma once

#include <string>

#include "capture/takes/take.h"

namespace CLI {
class App;
}

namespace airclay {

/// Parses the value of --units: m, mm or empty.
RigUnits parseUnits(const std::string& text);

/// Options of a take to read.
struct TakeInputOptions {
  std::string folder, units;
  int background_frames = 10;

  /// Opens the take and prints its note as a warning. A recording of a session may be incomplete.
  Take open(const TakeOptions& options = {}) const;
};

/// The take itself, --units and --background.
void addTakeOptions(CLI::App& command, TakeInputOptions& options);

}  // namespace airclay
