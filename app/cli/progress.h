// SPDX-License-Identifier: MIT
// Progress of long tasks: a bar on the terminal, and a clean exit on Ctrl-C.
#pragma once

#include <chrono>
#include <csignal>
#include <string>

#include "engine/core/task.h"

namespace airclay {

/// SIGINT or SIGTERM. Destructors close files and remove partial output.
struct Interrupted {
  int signal;
};

/// Counts the steps of a long task. While it exists, advance() throws Interrupted after SIGINT or SIGTERM; a
/// second signal ends the program at once.
class Progress {
 public:
  /// \param what  label of the bar
  /// \param shown draw the bar, if standard error is a terminal
  Progress(std::string what, int steps, bool shown);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Finishes one step. \throw Interrupted
  void advance();
  /// Sets the finished fraction of all steps, 0 to 1. \throw Interrupted
  void reach(double share);

 private:
  void show(bool now_too);
  void draw() const;

  std::string what_;
  int steps_, done_ = 0;
  bool shown_;
  std::chrono::steady_clock::time_point drawn_{};
  struct sigaction previous_interrupt_ {
  }, previous_end_{};
};

/// The same for code that reports its own progress (engine/core/task.h): files, subdivision. It can be
/// interrupted only where it reports.
class ProgressTask : public Task {
 public:
  ProgressTask(const std::string& what, bool shown) : progress_(what, 100, shown) {}
  void onProgress(double share) override { progress_.reach(share); }

 private:
  Progress progress_;
};

}  // namespace airclay
