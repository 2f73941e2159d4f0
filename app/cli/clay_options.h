// SPDX-License-Identifier: MIT
// The clay's command-line options, shared by the commands that take clay.
#pragma once

#include <string>

#include "engine/clay/clay_state.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace airclay {

/// How to subdivide and solve the clay, as given.
struct ClayOptions {
  std::string rule = "catmull-clark", solve = kSolveAll.id;
  int levels = 2;

  SubdivisionRule subdivisionRule() const {
    return rule == "printed" ? SubdivisionRule::kPrinted : SubdivisionRule::kCatmullClark;
  }
  /// \pre `solve` names a method
  const SolveMethod* solveMethod() const { return findSolveMethod(solve); }

  /// Null if the command has no such option.
  const CLI::Option *levels_option = nullptr, *rule_option = nullptr, *solve_option = nullptr;
  bool levelsGiven() const;
  /// Applies the options that were given to `state`.
  void applyTo(ClayState& state) const;
};

/// The value without the option, for its help text.
enum class WhenOmitted { kDefault, kKeep };

/// --levels and --rule.
void addSubdivisionOptions(CLI::App& command, ClayOptions& options,
                           WhenOmitted otherwise = WhenOmitted::kDefault);
/// --solve.
void addSolveOption(CLI::App& command, ClayOptions& options, WhenOmitted otherwise = WhenOmitted::kDefault);

}  // namespace airclay
