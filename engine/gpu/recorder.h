// SPDX-License-Identifier: MIT
// One submission: kernels in order, the barriers between them, and the time that each stage takes.
//
// Barriers come from declarations. A kernel's pointer arguments say what it reads and writes
// (shaders/core/io.h); the recorder finds the buffer behind each pointer and puts a barrier before the first
// dispatch that would race. hazards() is the independent check of that: synchronization validation sees no
// races through buffer addresses, and lavapipe runs in order, so neither would notice a barrier that is
// missing.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "engine/core/clock.h"
#include "engine/gpu/buffer.h"
#include "engine/gpu/kernel.h"

namespace airclay {

/// A use of one buffer by one recorded command.
struct Access {
  std::uint64_t buffer = 0;  ///< its device address
  bool reads = false, writes = false;
};

/// A recorded command, for hazards() and for whoever wants to see what a frame consists of.
struct RecordedCommand {
  std::string name;
  std::vector<Access> accesses;
  bool barrier_before = false;
};

/// Derives the barriers: feed it each command's accesses in order.
class HazardTracker {
 public:
  /// Whether the command races with one since the last barrier; then that barrier is taken as placed before
  /// it.
  bool needsBarrier(const std::vector<Access>& accesses);
  void reset();

 private:
  std::set<std::uint64_t> read_, written_;  ///< since the last barrier
};

/// The pairs (earlier, later) of commands that use one buffer, one of them writing, with no barrier after the
/// earlier and up to the later.
std::vector<std::pair<int, int>> hazards(const std::vector<RecordedCommand>& commands);

/// Milliseconds on the device by stage, in order of first appearance.
using StageTimes = std::vector<std::pair<std::string, double>>;
void addStages(const StageTimes& stages, StageTimes& total);
/// Takes the place of what `latest` says of the same stages.
void renewStages(const StageTimes& stages, StageTimes& latest);

/// Whether a submission's stages are timed.
enum class Timing {
  kStages,
  /// Timestamps are dear on lavapipe: once anything was drawn, each is an empty scene of the last image's
  /// size, 0.06 to 0.1 ms (0.18 of an empty submission's 0.21 ms on two cores).
  kNone,
};

/// Which of many submissions alike to time: one in `every`; 0: all, but on a software device one in eight.
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

  /// Starts an empty command buffer. \pre nothing recorded is still running
  void begin(Timing timing = Timing::kStages);

  /// What follows is timed under this name, if anything is; a name may come more than once.
  void stage(const std::string& name);

  template <class Args>
  void dispatch(const Kernel<Args>& kernel, const Args& args, std::uint32_t x, std::uint32_t y = 1,
                std::uint32_t z = 1) {
    dispatchRaw(kernel, &args, sizeof(Args), x, y, z);
  }
  /// Workgroup counts from three uints on the device.
  template <class Args>
  void dispatchIndirect(const Kernel<Args>& kernel, const Args& args, const RawBuffer& groups,
                        std::uint64_t byte_offset) {
    dispatchIndirectRaw(kernel, &args, sizeof(Args), groups, byte_offset);
  }
  /// Sets every word of the buffer.
  void fill(const RawBuffer& buffer, std::uint32_t word);
  /// Writes a few bytes that are copied now (at most 65,536, a multiple of 4).
  void update(const RawBuffer& buffer, const void* data, std::uint64_t bytes);
  void copy(const RawBuffer& from, const RawBuffer& to, std::uint64_t bytes);

  /// For commands of other makers (the renderer's): declares their accesses, places the barrier, returns the
  /// command buffer.
  VkCommandBuffer commandsFor(const std::string& name, const std::vector<Access>& accesses);
  /// The accesses that these arguments mean by their shader's declarations.
  std::vector<Access> accessesOf(const std::vector<PointerArgument>& pointers, const void* args) const;

  /// Runs what is recorded so far, and waits: other threads' submissions that wait for the queue come in
  /// between. For work that would hold them up for long.
  void divide();

  /// Submits all since begin(), or since divide(), as one submission, and waits.
  void submitAndWait();
  /// Without waiting for its end; a window's images are waited for and signalled by semaphores.
  void submit(const VkSemaphoreSubmitInfo* wait_for = nullptr, const VkSemaphoreSubmitInfo* signal = nullptr);
  void wait();

  /// Of the last submission; none when it was not timed.
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

/// The same workgroups in rows of at most 32,768, for counts past the 65,535 that every device takes in x
/// (shaders/core/invocation.glsl finds the invocation's index).
struct GroupRows {
  std::uint32_t x = 1, y = 1;
};
inline GroupRows groupRowsFor(std::size_t count, std::uint32_t size) {
  const std::uint32_t groups = groupsFor(count, size);
  const std::uint32_t rows = groupsFor(groups, 32'768);
  return rows <= 1 ? GroupRows{groups, 1} : GroupRows{groupsFor(groups, rows), rows};
}

}  // namespace airclay
