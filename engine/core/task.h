// SPDX-License-Identifier: MIT
// Progress reports and cancellation of long operations.
//
// Loops that may run for seconds (subdividing, reading and writing meshes, factorizing) call
// reportProgress(). To listen, create a Task on the thread that does the work. Without a Task,
// reportProgress() does nothing.
#pragma once

#include <cstddef>

namespace airclay {

/// Receives the progress of the work on this thread while it exists. The most recently created Task receives
/// it.
class Task {
 public:
  Task();
  virtual ~Task();
  Task(const Task&) = delete;
  Task& operator=(const Task&) = delete;

  /// `fraction` of the current step is done, 0 to 1. To cancel, throw: the work unwinds and leaves everything
  /// unchanged.
  virtual void onProgress(double fraction) = 0;

 private:
  Task* const previous_;
};

/// Reports to the thread's Task, if any. Cheap enough for every few thousand elements. \throw what the Task
/// throws to cancel
void reportProgress(double fraction);
/// The same for element `done` of `total`; only every 4,096th call reports.
void reportProgress(std::size_t done, std::size_t total);

}  // namespace airclay
