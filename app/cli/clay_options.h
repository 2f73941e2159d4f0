// SPDX-License-Identifier: MIT
// The clay's words on the command line, shared by the commands that take clay.
#pragma once

#include <string>

#include "engine/clay/clay_state.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace airclay {

/// How the clay is subdivided and solved, as written.
struct ClayOptions {
  std::string rule = "catmull-clark", solve = kSolveAll.id;
  int levels = 2;

  SubdivisionRule subdivisionRule() const {
    return rule == "printed" ? SubdivisionRule::kPrinted : SubdivisionRule::kCatmullClark;
  }
  /// \pre `solve` names a method
  const SolveMethod* solveMethod() const { return findSolveMethod(solve); }

  /// Of the options; none where the command has no such option.
  const CLI::Option *levels_option = nullptr, *rule_option = nullptr, *solve_option = nullptr;
  bool levelsGiven() const;
  /// Puts what was given on the command line into `state`; the rest stays as it is.
  void applyTo(ClayState& state) const;
};

/// What holds where an option is not given, for its help.
enum class WhenOmitted { kDefault, kKeep };

/// --levels and --rule.
void addSubdivisionOptions(CLI::App& command, ClayOptions& options,
                           WhenOmitted otherwise = WhenOmitted::kDefault);
/// --solve.
void addSolveOption(CLI::App& command, ClayOptions& options, WhenOmitted otherwise = WhenOmitted::kDefault);

}  // namespace airclay
