// SPDX-License-Identifier: MIT
#include "engine/gpu/recorder.h"

#include <algorithm>
#include <utility>

#include "engine/core/error.h"

namespace airclay {

bool HazardTracker::needsBarrier(const std::vector<Access>& accesses) {
  const bool races = std::any_of(accesses.begin(), accesses.end(), [&](const Access& access) {
    return written_.count(access.buffer) || (access.writes && read_.count(access.buffer));
  });
  if (races) reset();
  for (const Access& access : accesses) {
    if (access.reads) read_.insert(access.buffer);
    if (access.writes) written_.insert(access.buffer);
  }
  return races;
}

void HazardTracker::reset() {
  read_.clear();
  written_.clear();
}

std::vector<std::pair<int, int>> hazards(const std::vector<RecordedCommand>& commands) {
  std::vector<std::pair<int, int>> found;
  const auto conflict = [](const RecordedCommand& a, const RecordedCommand& b) {
    for (const Access& x : a.accesses)
      for (const Access& y : b.accesses)
        if (x.buffer == y.buffer && (x.writes || y.writes)) return true;
    return false;
  };
  for (int later = 0; later < static_cast<int>(commands.size()); ++later) {
    // walk back until a barrier separates the two; the barrier before `later` separates it from all earlier
    // commands
    for (int earlier = later; earlier > 0 && !commands[static_cast<std::size_t>(earlier)].barrier_before;
         --earlier)
      if (conflict(commands[static_cast<std::size_t>(earlier - 1)],
                   commands[static_cast<std::size_t>(later)]))
        found.emplace_back(earlier - 1, later);
  }
  return found;
}

Recorder::Recorder(Gpu& gpu) : gpu_(gpu) {
  VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  pool.queueFamilyIndex = gpu.queueFamily();
  check(vkCreateCommandPool(gpu.device(), &pool, nullptr, &pool_), "create a command pool");
  VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = pool_;
  allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  allocate.commandBufferCount = 1;
  check(vkAllocateCommandBuffers(gpu.device(), &allocate, &command_buffer_), "create a command buffer");
  const VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, nullptr, 0};
  check(vkCreateFence(gpu.device(), &fence, nullptr, &fence_), "create a fence");
  VkQueryPoolCreateInfo queries{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
  queries.queryType = VK_QUERY_TYPE_TIMESTAMP;
  queries.queryCount = kMaxStages + 1;
  check(vkCreateQueryPool(gpu.device(), &queries, nullptr, &queries_), "create a timestamp query pool");
}

Recorder::~Recorder() {
  if (running_) vkWaitForFences(gpu_.device(), 1, &fence_, VK_TRUE, UINT64_MAX);
  vkDestroyQueryPool(gpu_.device(), queries_, nullptr);
  vkDestroyFence(gpu_.device(), fence_, nullptr);
  vkDestroyCommandPool(gpu_.device(), pool_, nullptr);
}

void Recorder::begin(Timing timing) {
  timed_ = timing == Timing::kStages;
  commands_.clear();
  stages_.clear();
  divided_ = false;
  beginCommands();
  if (timed_) vkCmdResetQueryPool(command_buffer_, queries_, 0, kMaxStages + 1);
  // another thread's submission may still use the same buffers; a software device runs in order
  if (!gpu_.isCpu()) barrier();
}

void Recorder::beginCommands() {
  tracker_.reset();
  bound_ = VK_NULL_HANDLE;
  // an error may have cut the last recording short; such a buffer cannot begin again without a reset
  check(vkResetCommandBuffer(command_buffer_, 0), "record commands");
  VkCommandBufferBeginInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  check(vkBeginCommandBuffer(command_buffer_, &info), "record commands");
}

void Recorder::divide() {
  endCommands();
  gpu_.submit(command_buffer_, fence_);
  running_ = true;
  waitForEnd();
  beginCommands();
  barrier();
  divided_ = true;
}

void Recorder::stage(const std::string& name) {
  if (!timed_) return;
  if (stages_.size() >= kMaxStages) throw Error("a submission has too many stages", Fault::kDevice);
  vkCmdWriteTimestamp2(command_buffer_, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, queries_,
                       static_cast<std::uint32_t>(stages_.size()));
  // once it has drawn anything, lavapipe delays timestamps until a flush; without this barrier a stage of
  // kernels would take 0 ms. On other devices stages depend on each other anyway.
  if (gpu_.isCpu()) barrier();
  stages_.push_back(name);
}

void Recorder::barrier() {
  VkMemoryBarrier2 memory{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
  memory.srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  memory.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
  memory.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  memory.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
  VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  dependency.memoryBarrierCount = 1;
  dependency.pMemoryBarriers = &memory;
  vkCmdPipelineBarrier2(command_buffer_, &dependency);
}

VkCommandBuffer Recorder::commandsFor(const std::string& name, const std::vector<Access>& accesses) {
  bool needed = tracker_.needsBarrier(accesses);
  if (needed) barrier();
  if (std::exchange(divided_, false)) needed = true;  // it is already recorded
  commands_.push_back({name, accesses, needed});
  return command_buffer_;
}

std::vector<Access> Recorder::accessesOf(const std::vector<PointerArgument>& pointers,
                                         const void* args) const {
  std::vector<Access> accesses;
  for (const PointerArgument& pointer : pointers) {
    std::uint64_t address;
    std::memcpy(&address, static_cast<const unsigned char*>(args) + pointer.offset, sizeof address);
    if (address == 0) continue;  // an optional argument that is not set
    const std::uint64_t buffer = gpu_.liveBufferAt(address);
    if (buffer == 0) throw Error("a kernel argument points outside all live buffers", Fault::kDevice);
    accesses.push_back({buffer, pointer.reads, pointer.writes});
  }
  return accesses;
}

void Recorder::bind(const RawKernel& kernel, const void* args, std::uint32_t bytes) {
  if (bound_ != kernel.pipeline()) {
    vkCmdBindPipeline(command_buffer_, VK_PIPELINE_BIND_POINT_COMPUTE, kernel.pipeline());
    bound_ = kernel.pipeline();
  }
  vkCmdPushConstants(command_buffer_, kernel.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, bytes, args);
}

void Recorder::dispatchRaw(const RawKernel& kernel, const void* args, std::uint32_t bytes, std::uint32_t x,
                           std::uint32_t y, std::uint32_t z) {
  commandsFor(kernel.name(), accessesOf(kernel.pointers(), args));
  bind(kernel, args, bytes);
  vkCmdDispatch(command_buffer_, x, y, z);
}

void Recorder::dispatchIndirectRaw(const RawKernel& kernel, const void* args, std::uint32_t bytes,
                                   const RawBuffer& groups, std::uint64_t byte_offset) {
  std::vector<Access> accesses = accessesOf(kernel.pointers(), args);
  accesses.push_back({groups.address(), true, false});
  commandsFor(kernel.name(), accesses);
  bind(kernel, args, bytes);
  vkCmdDispatchIndirect(command_buffer_, groups.handle(), groups.offset() + byte_offset);
}

void Recorder::fill(const RawBuffer& buffer, std::uint32_t word) {
  commandsFor("fill", {{buffer.address(), false, true}});
  vkCmdFillBuffer(command_buffer_, buffer.handle(), buffer.offset(), buffer.bytes() / 4 * 4, word);
}

void Recorder::update(const RawBuffer& buffer, const void* data, std::uint64_t bytes) {
  commandsFor("update", {{buffer.address(), false, true}});
  vkCmdUpdateBuffer(command_buffer_, buffer.handle(), buffer.offset(), bytes, data);
}

void Recorder::copy(const RawBuffer& from, const RawBuffer& to, std::uint64_t bytes) {
  commandsFor("copy", {{from.address(), true, false}, {to.address(), false, true}});
  const VkBufferCopy region{from.offset(), to.offset(), bytes};
  vkCmdCopyBuffer(command_buffer_, from.handle(), to.handle(), 1, &region);
}

void Recorder::endCommands() {
  VkMemoryBarrier2 memory{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
  memory.srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  memory.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
  memory.dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT;
  memory.dstAccessMask = VK_ACCESS_2_HOST_READ_BIT;
  VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  dependency.memoryBarrierCount = 1;
  dependency.pMemoryBarriers = &memory;
  vkCmdPipelineBarrier2(command_buffer_, &dependency);
  check(vkEndCommandBuffer(command_buffer_), "record commands");
  check(vkResetFences(gpu_.device(), 1, &fence_), "reset a fence");
  submitted_at_ = Clock::now();
}

void Recorder::submit(const VkSemaphoreSubmitInfo* wait_for, const VkSemaphoreSubmitInfo* signal) {
  if (!stages_.empty())
    vkCmdWriteTimestamp2(command_buffer_, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, queries_,
                         static_cast<std::uint32_t>(stages_.size()));
  endCommands();
  gpu_.submit(command_buffer_, fence_, wait_for, signal);
  running_ = true;
}

void Recorder::waitForEnd() {
  check(vkWaitForFences(gpu_.device(), 1, &fence_, VK_TRUE, UINT64_MAX), "wait for the device");
  running_ = false;
  gpu_.noteEnd(submitted_at_);
}

void Recorder::wait() {
  waitForEnd();
  readTimestamps();
}

void Recorder::submitAndWait() {
  submit();
  wait();
}

namespace {

/// The time of the named stage, 0 if it is new.
double& timeOf(const std::string& name, StageTimes& times) {
  const auto same =
      std::find_if(times.begin(), times.end(), [&](const auto& stage) { return stage.first == name; });
  return same == times.end() ? times.emplace_back(name, 0).second : same->second;
}

}  // namespace

void addStages(const StageTimes& stages, StageTimes& total) {
  for (const auto& [name, ms] : stages) timeOf(name, total) += ms;
}

void renewStages(const StageTimes& stages, StageTimes& latest) {
  for (const auto& [name, ms] : stages) timeOf(name, latest) = ms;
}

void Recorder::readTimestamps() {
  stage_ms_.clear();
  if (stages_.empty()) return;
  const std::size_t count = stages_.size() + 1;
  std::vector<std::uint64_t> ticks(count);
  check(vkGetQueryPoolResults(gpu_.device(), queries_, 0, static_cast<std::uint32_t>(count), count * 8,
                              ticks.data(), 8, VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
        "read the timestamps");
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    const double ms = static_cast<double>(ticks[i + 1] - ticks[i]) *
                      static_cast<double>(gpu_.limits().timestampPeriod) * 1e-6;
    addStages({{stages_[i], ms}}, stage_ms_);
  }
}

}  // namespace airclay
