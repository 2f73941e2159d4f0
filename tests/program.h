// SPDX-License-Identifier: MIT
// The built program, run as a user runs it.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace airclay {

/// What a run left.
struct Ran {
  int status = -1;  ///< exit status; 128 + the signal that ended it
  std::string output, errors;

  /// Lines of standard error.
  std::vector<std::string> errorLines() const;
};

struct RunOptions {
  std::map<std::string, std::string> environment;  ///< on top of this process' own
  int terminate_after_ms = 0;                      ///< SIGTERM after so long; 0: let it end
};

/// Runs `airclay` with these words; neither of its streams is a terminal.
Ran runAirclay(const std::vector<std::string>& words, const RunOptions& options = {});

}  // namespace airclay
