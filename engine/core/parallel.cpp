// SPDX-License-Identifier: MIT
#include "engine/core/parallel.h"

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "engine/core/task.h"

namespace airclay {
namespace {

/// The cores that this thread may use; std::thread::hardware_concurrency() counts all.
std::size_t coreCount() {
  cpu_set_t cores;
  const bool known = sched_getaffinity(0, sizeof cores, &cores) == 0;
  return known ? std::size_t(CPU_COUNT(&cores)) : std::max(1u, std::thread::hardware_concurrency());
}

}  // namespace

void parallelFor(std::size_t count, std::size_t grain,
                 const std::function<void(std::size_t, std::size_t)>& body) {
  const std::size_t ranges = (count + grain - 1) / grain;
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> failed = false;
  std::exception_ptr failure;
  std::mutex mutex;
  const auto work = [&](bool reports) {
    try {
      for (std::size_t range = next++; range < ranges && !failed; range = next++) {
        body(range * grain, std::min(count, (range + 1) * grain));
        if (reports) reportProgress(double(range + 1) / double(ranges));
      }
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!failure) failure = std::current_exception();
      failed = true;
    }
  };
  std::vector<std::thread> threads;
  for (std::size_t t = 1; t < std::min(coreCount(), ranges); ++t) threads.emplace_back(work, false);
  work(true);
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace airclay
