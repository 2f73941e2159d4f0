// SPDX-License-Identifier: MIT
// The options of the commands that read a take.
#pragma once

#include <limits>
#include <string>
#include <vector>

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
  std::vector<std::string> offsets;  ///< NAME=MS each
  int background_frames = 10;

  TakeOptions takeOptions() const;
  /// Opens the take and prints its note as a warning. A recording of a session may be incomplete.
  Take open(int max_frames = std::numeric_limits<int>::max()) const;
};

/// The take itself, and addTakeReadingOptions().
void addTakeOptions(CLI::App& command, TakeInputOptions& options);
/// --units, --background and, unless the command has it for cameras, --offset.
void addTakeReadingOptions(CLI::App& command, TakeInputOptions& options);

}  // namespace airclay
