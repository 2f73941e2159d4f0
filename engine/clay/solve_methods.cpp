// SPDX-License-Identifier: MIT
#include <algorithm>

#include "engine/clay/solve_method.h"

namespace airclay {
namespace {

/// To add a solve method, add it here.
constexpr const SolveMethod* kSolveMethods[] = {&kSolveAll, &kSolveTouched};

}  // namespace

std::span<const SolveMethod* const> solveMethods() {
  return kSolveMethods;
}

const SolveMethod* findSolveMethod(std::string_view id) {
  const auto found = std::ranges::find(
      kSolveMethods, id, [](const SolveMethod* method) { return std::string_view(method->id); });
  return found == std::end(kSolveMethods) ? nullptr : *found;
}

std::string solveMethodIds() {
  std::string list;
  for (std::size_t i = 0; i < std::size(kSolveMethods); ++i)
    list += (i == 0                             ? ""
             : i + 1 < std::size(kSolveMethods) ? ", "
                                                : " or ") +
            std::string(kSolveMethods[i]->id);
  return list;
}

}  // namespace airclay
