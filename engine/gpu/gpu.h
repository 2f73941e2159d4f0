// SPDX-License-Identifier: MIT
// The Vulkan device: selection, required features, and the live buffers in its memory.
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "engine/core/clock.h"

namespace airclay {

/// A device as listed by `airclay devices`.
struct DeviceInfo {
  std::string name;
  std::string type;  ///< discrete, integrated, virtual, cpu
  std::string driver;
  std::uint32_t api_version = 0;
  std::uint64_t memory_bytes = 0;    ///< of the largest device-local heap
  std::vector<std::string> missing;  ///< names of missing required features; empty if usable
};

struct GpuOptions {
  std::string device;       ///< index or part of a name; empty: the best usable device
  bool validation = false;  ///< the Khronos layer with synchronization checks; messages are collected
  bool guards = false;      ///< guard bytes before and after every buffer, for damagedGuards()
};

/// Messages of the validation layer, which calls from any thread.
struct ValidationMessages {
  mutable std::mutex mutex;
  std::vector<std::string> texts;
};

/// One device, one queue for compute and graphics. Not copyable; must outlive everything created on it.
/// Threads may share it: each records with its own Recorder.
class Gpu {
 public:
  /// \throw Error (Fault::kDevice) if there is no such device, or if it lacks a required feature.
  explicit Gpu(const GpuOptions& options = {});
  ~Gpu();
  Gpu(const Gpu&) = delete;
  Gpu& operator=(const Gpu&) = delete;

  /// All devices of this machine, in the order that --device counts them. \throw Error without a Vulkan
  /// loader
  static std::vector<DeviceInfo> devices();

  const DeviceInfo& info() const { return info_; }
  VkDevice device() const { return device_; }
  VkPhysicalDevice physicalDevice() const { return physical_device_; }
  VkInstance instance() const { return instance_; }
  /// For code that must pass the queue on (a window toolkit), with queueMutex() locked.
  VkQueue queue() const { return queue_; }
  std::mutex& queueMutex() { return queue_mutex_; }
  std::uint32_t queueFamily() const { return queue_family_; }
  const VkPhysicalDeviceLimits& limits() const { return limits_; }

  /// True for a software device (lavapipe): barriers inside a workgroup are expensive there, so workgroups
  /// are one subgroup.
  bool isCpu() const { return is_cpu_; }
  std::uint32_t subgroupSize() const { return subgroup_size_; }
  /// Workgroup size for reductions in shared memory.
  std::uint32_t reductionWorkgroup() const { return is_cpu_ ? subgroup_size_ : 256; }

  /// Submits a recorded command buffer, with optional wait and signal semaphores; `fence` is signalled at its
  /// end.
  void submit(VkCommandBuffer commands, VkFence fence, const VkSemaphoreSubmitInfo* wait = nullptr,
              const VkSemaphoreSubmitInfo* signal = nullptr);

  /// Called by the thread that waited: the submission of that time has just ended.
  void noteEnd(Clock::time_point submitted);
  /// Duration of the longest submission since the last call, milliseconds, as seen by the waiting thread.
  double takeLongestSubmissionMs();

  /// Waits until everything submitted is done.
  void waitIdle();

  /// Messages of the validation layer since the start; a test expects none.
  std::vector<std::string> validationMessages() const;

  /// A memory type that has all of `required`, and preferably `preferred` too.
  std::uint32_t memoryType(std::uint32_t type_bits, VkMemoryPropertyFlags required,
                           VkMemoryPropertyFlags preferred) const;

  // --- live buffers, by device address: the recorder finds the buffer that a pointer points into ---
  struct LiveBuffer {
    std::uint64_t bytes = 0;           ///< without guards
    unsigned char* guarded = nullptr;  ///< mapped memory including guards; null when not mapped
  };
  void addLiveBuffer(std::uint64_t address, const LiveBuffer& buffer);
  void removeLiveBuffer(std::uint64_t address);
  /// The start address of the live buffer that contains `address`; 0 if there is none.
  std::uint64_t liveBufferAt(std::uint64_t address) const;
  /// The number of live buffers whose guard bytes were overwritten.
  int damagedGuards() const;
  bool guards() const { return guards_; }

  static constexpr std::uint32_t kGuardBytes = 256;  ///< a multiple of every alignment in use
  static constexpr unsigned char kGuardByte = 0xA5;

 private:
  struct Empty {};
  explicit Gpu(Empty) {}  // delegated to, so that a constructor that throws still destroys what it created
  void createInstance(bool validation);
  void createDevice();

  VkInstance instance_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  VkPhysicalDevice physical_device_ = VK_NULL_HANDLE;
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
  std::uint32_t queue_family_ = 0;
  std::uint32_t subgroup_size_ = 1;
  bool is_cpu_ = false;
  bool guards_ = false;
  VkPhysicalDeviceLimits limits_{};
  VkPhysicalDeviceMemoryProperties memory_{};
  DeviceInfo info_;
  std::mutex queue_mutex_;
  std::mutex ends_mutex_;  ///< guards the next two members
  Clock::time_point last_end_{};
  double longest_submission_s_ = 0;
  ValidationMessages messages_;
  mutable std::mutex live_buffers_mutex_;
  std::map<std::uint64_t, LiveBuffer> live_buffers_;
};

/// \throw Error (Fault::kDevice) unless `result` is success; `doing` completes "could not …".
void check(VkResult result, const char* doing);

}  // namespace airclay
