// SPDX-License-Identifier: MIT
// Work that takes long says how far it is, and can be cancelled.
//
// Loops that may run for seconds (subdividing, reading and writing meshes, factorizing) call
// reportProgress(). Whoever wants to know puts a Task in place on the thread that does the work; otherwise
// nothing happens.
#pragma once

#include <cstddef>

namespace airclay {

/// Told of the work that is done on this thread while it exists. The one put in place last is told.
class Task {
 public:
  Task();
  virtual ~Task();
  Task(const Task&) = delete;
  Task& operator=(const Task&) = delete;

  /// `share` of the step under way is done, 0 to 1. To cancel, throw: the work unwinds and leaves everything
  /// as it was.
  virtual void onProgress(double share) = 0;

 private:
  Task* const before_;
};

/// Tells the thread's Task, if any. Cheap enough for every few thousand elements. \throw what cancels
void reportProgress(double share);
/// The same for element `done` of `total`, of which every 4,096th is told.
void reportProgress(std::size_t done, std::size_t total);

}  // namespace airclay
