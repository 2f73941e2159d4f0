// SPDX-License-Identifier: MIT
// One submission: kernels in order, the barriers between them, and the time of each stage.
//
// Barriers come from declarations. A kernel's pointer arguments declare what it reads and writes
// (shaders/core/io.h); the recorder finds the buffer behind each pointer and places a barrier before the
// first dispatch that would race. hazards() checks this independently: synchronization validation does not
// see races through buffer addresses, and lavapipe runs in order, so neither would notice a missing barrier.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "engine/core/clock.h"
#include "engine/gpu/buffer.h"
#include "engine/gpu/kernel.h"

namespace airclay {

/// The use of one buffer by one recorded command.
struct Access {
  std::uint64_t buffer = 0;  ///< its device address
  bool reads = false, writes = false;
};

/// A recorded command, for hazards() and for inspecting a frame.
struct RecordedCommand {
  std::string name;
  std::vector<Access> accesses;
  bool barrier_before = false;
};

/// Derives the barriers from each command's accesses, passed in order.
class HazardTracker {
 public:
  /// Whether the command races with one since the last barrier; if so, assumes that the barrier is placed
  /// before it.
  bool needsBarrier(const std::vector<Access>& accesses);
  void reset();

 private:
  std::set<std::uint64_t> read_, written_;  ///< since the last barrier
};

/// The pairs (earlier, later) of commands that access the same buffer, at least one of them writing, with no
/// barrier between them.
std::vector<std::pair<int, int>> hazards(const std::vector<RecordedCommand>& commands);

/// Milliseconds on the device by stage, in order of first appearance.
using StageTimes = std::vector<std::pair<std::string, double>>;
void addStages(const StageTimes& stages, StageTimes& total);
/// Replaces the times of the same stages in `latest`.
void renewStages(const StageTimes& stages, StageTimes& latest);

/// Whether a submission's stages are timed.
enum class Timing {
  kStages,
  /// Timestamps are expensive on lavapipe: once anything was drawn, each costs an empty scene of the last
  /// image's size, 0.06 to 0.1 ms (0.18 of an empty submission's 0.21 ms on two cores).
  kNone,
};

/// Which of many similar submissions to time: one in `every`; 0: all, but one in eight on a software device.
class TimingPlan {
 public:
  TimingPlan(const Gpu& gpu, int every) : every_(every > 0 ? every : gpu.isCpu() ? 8 : 1) {}
  Timing next() { return submissions_++ % every_ == 0 ? Timing::kStages : Timing::kNone; }

 private:
  int every_, submissions_ = 0;
};

class Recorder {
 public:
  explicit Recorder(Gpu& gpu);
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Starts an empty command buffer. \pre no recorded commands are still running
  void begin(Timing timing = Timing::kStages);

  /// Times what follows under this name, if timing is on; a name may occur more than once.
  void stage(const std::string& name);

  template <class Args>
  void dispatch(const Kernel<Args>& kernel, const Args& args, std::uint32_t x, std::uint32_t y = 1,
                std::uint32_t z = 1) {
    dispatchRaw(kernel, &args, sizeof(Args), x, y, z);
  }
  /// Workgroup counts are three uints on the device.
  template <class Args>
  void dispatchIndirect(const Kernel<Args>& kernel, const Args& args, const RawBuffer& groups,
                        std::uint64_t byte_offset) {
    dispatchIndirectRaw(kernel, &args, sizeof(Args), groups, byte_offset);
  }
  /// Sets every word of the buffer.
  void fill(const RawBuffer& buffer, std::uint32_t word);
  /// Writes up to 65,536 bytes, a multiple of 4, copied at the time of the call.
  void update(const RawBuffer& buffer, const void* data, std::uint64_t bytes);
  void copy(const RawBuffer& from, const RawBuffer& to, std::uint64_t bytes);

  /// For commands recorded elsewhere (by the renderer): declares their accesses, places the barrier, returns
  /// the command buffer.
  VkCommandBuffer commandsFor(const std::string& name, const std::vector<Access>& accesses);
  /// The accesses of these arguments, by their shader's declarations.
  std::vector<Access> accessesOf(const std::vector<PointerArgument>& pointers, const void* args) const;

  /// Submits what is recorded so far and waits, so that submissions of other threads can run in between. For
  /// work that would block them for long.
  void divide();

  /// Submits everything since begin() or divide() as one submission, and waits.
  void submitAndWait();
  /// Submits without waiting; a window's images are waited for and signalled by semaphores.
  void submit(const VkSemaphoreSubmitInfo* wait_for = nullptr, const VkSemaphoreSubmitInfo* signal = nullptr);
  void wait();

  /// Of the last submission; empty if it was not timed.
  const StageTimes& stageMs() const { return stage_ms_; }
  /// The commands since begin().
  const std::vector<RecordedCommand>& commands() const { return commands_; }

 private:
  void dispatchRaw(const RawKernel& kernel, const void* args, std::uint32_t bytes, std::uint32_t x,
                   std::uint32_t y, std::uint32_t z);
  void dispatchIndirectRaw(const RawKernel& kernel, const void* args, std::uint32_t bytes,
                           const RawBuffer& groups, std::uint64_t byte_offset);
  void bind(const RawKernel& kernel, const void* args, std::uint32_t bytes);
  void beginCommands();
  void endCommands();
  void waitForEnd();
  void barrier();
  void readTimestamps();

  static constexpr std::uint32_t kMaxStages = 256;

  Gpu& gpu_;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer command_buffer_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
  VkQueryPool queries_ = VK_NULL_HANDLE;
  VkPipeline bound_ = VK_NULL_HANDLE;
  bool running_ = false;  ///< submitted and not waited for
  bool timed_ = true;
  bool divided_ = false;  ///< the next command is the first after divide()
  Clock::time_point submitted_at_;
  HazardTracker tracker_;
  std::vector<RecordedCommand> commands_;
  std::vector<std::string> stages_;
  StageTimes stage_ms_;
};

/// Workgroups of `size` that cover `count` invocations.
inline std::uint32_t groupsFor(std::size_t count, std::uint32_t size) {
  return static_cast<std::uint32_t>((count + size - 1) / size);
}

/// The same workgroups in rows of at most 32,768, for counts above the 65,535 that every device accepts in x
/// (shaders/core/invocation.glsl computes the invocation's index).
struct GroupRows {
  std::uint32_t x = 1, y = 1;
};
inline GroupRows groupRowsFor(std::size_t count, std::uint32_t size) {
  const std::uint32_t groups = groupsFor(count, size);
  const std::uint32_t rows = groupsFor(groups, 32'768);
  return rows <= 1 ? GroupRows{groups, 1} : GroupRows{groupsFor(groups, rows), rows};
}

}  // namespace airclay
