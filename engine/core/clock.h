// SPDX-License-Identifier: MIT
// The clock that durations are measured with.
#pragma once

#include <chrono>

namespace airclay {

using Clock = std::chrono::steady_clock;

inline double secondsBetween(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}
inline double millisecondsSince(Clock::time_point start) {
  return 1000 * secondsBetween(start, Clock::now());
}

}  // namespace airclay
