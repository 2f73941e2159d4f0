// SPDX-License-Identifier: MIT
// Long work: a bar on a terminal, and a clean end on Ctrl-C.
#pragma once

#include <chrono>
#include <csignal>
#include <string>

#include "engine/core/task.h"

namespace airclay {

/// Ctrl-C, or the system's wish to end: what was open is closed, what was half written is gone.
struct Interrupted {
  int signal;
};

/// Counts the steps of long work. While one exists, SIGINT and SIGTERM come out of advance() as Interrupted;
/// a second one ends the program at once.
class Progress {
 public:
  /// \param what  a word or two before the bar
  /// \param shown whether a bar may be drawn; it is, where standard error is a terminal
  Progress(std::string what, int steps, bool shown);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// One step is done. \throw Interrupted
  void advance();
  /// All steps together are done up to here, 0 to 1. \throw Interrupted
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

/// The same for work that says itself how far it is (engine/core/task.h): files, subdivision. Between two
/// signs of life it cannot be interrupted.
class ProgressTask : public Task {
 public:
  ProgressTask(const std::string& what, bool shown) : progress_(what, 100, shown) {}
  void onProgress(double share) override { progress_.reach(share); }

 private:
  Progress progress_;
};

}  // namespace airclay
