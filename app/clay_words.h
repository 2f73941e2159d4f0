// SPDX-License-Identifier: MIT
// The clay's words on the command line, shared by the commands that take clay.
#pragma once

#include <string>

#include "engine/solve.h"
#include "engine/subdivide.h"

namespace CLI {
class App;
}

namespace airclay {

/// How the clay is subdivided and solved, as written.
struct ClayWords {
  std::string rule = "catmull-clark", solve = "all";
  int levels = 2;

  SubdivisionRule subdivisionRule() const {
    return rule == "printed" ? SubdivisionRule::kPrinted : SubdivisionRule::kCatmullClark;
  }
  SolveRows solveRows() const { return solve == "touched" ? SolveRows::kTouched : SolveRows::kAll; }
};

/// --levels and --rule.
void addSubdivisionOptions(CLI::App& command, ClayWords& words);
/// --solve.
void addSolveOption(CLI::App& command, ClayWords& words);

}  // namespace airclay
