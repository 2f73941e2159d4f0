// SPDX-License-Identifier: MIT
// The Vulkan device: which one, with what it must have, and the memory that is live on it.
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "engine/core/clock.h"

namespace airclay {

/// What `airclay devices` shows of a device.
struct DeviceInfo {
  std::string name;
  std::string type;  ///< discrete, integrated, virtual, cpu
  std::string driver;
  std::uint32_t api_version = 0;
  std::uint64_t memory_bytes = 0;    ///< of the largest device-local heap
  std::vector<std::string> missing;  ///< names of required features that it lacks; empty when usable
};

struct GpuOptions {
  std::string device;       ///< index or part of a name; empty: the best usable one
  bool validation = false;  ///< the Khronos layer with synchronization checks; messages are collected
  bool guards = false;      ///< guard words before and behind every buffer, for damagedGuards()
};

/// What the validation layer said; it calls from any thread.
struct ValidationMessages {
  mutable std::mutex mutex;
  std::vector<std::string> texts;
};

/// One device, one queue for compute and graphics. Not copyable; outlives all that is made on it. Threads may
/// share it: each records with a Recorder of its own.
class Gpu {
 public:
  /// \throw Error (Fault::kDevice) when there is no such device, or naming what it lacks.
  explicit Gpu(const GpuOptions& options = {});
  ~Gpu();
  Gpu(const Gpu&) = delete;
  Gpu& operator=(const Gpu&) = delete;

  /// All devices of this machine, in the order that --device counts them. \throw Error without a Vulkan
  /// loader.
  static std::vector<DeviceInfo> devices();

  const DeviceInfo& info() const { return info_; }
  VkDevice device() const { return device_; }
  VkPhysicalDevice physicalDevice() const { return physical_device_; }
  VkInstance instance() const { return instance_; }
  /// For whoever must give the queue to others (a window's toolkit), with queueMutex() held.
  VkQueue queue() const { return queue_; }
  std::mutex& queueMutex() { return queue_mutex_; }
  std::uint32_t queueFamily() const { return queue_family_; }
  const VkPhysicalDeviceLimits& limits() const { return limits_; }

  /// True for a software device (lavapipe): barriers inside a workgroup are dear, so workgroups are one
  /// subgroup.
  bool isCpu() const { return is_cpu_; }
  std::uint32_t subgroupSize() const { return subgroup_size_; }
  /// Invocations of a workgroup that reduces in shared memory.
  std::uint32_t reductionWorkgroup() const { return is_cpu_ ? subgroup_size_ : 256; }

  /// Submits a recorded command buffer, with what it waits for and signals, if anything; `fence` tells its
  /// end.
  void submit(VkCommandBuffer commands, VkFence fence, const VkSemaphoreSubmitInfo* wait = nullptr,
              const VkSemaphoreSubmitInfo* signal = nullptr);

  /// Told by whoever waits for submissions: one of this time has just ended.
  void noteEnd(Clock::time_point submitted);
  /// How long the longest submission since the last call ran, milliseconds, as seen by who waited for it.
  double takeLongestSubmissionMs();

  /// Until all that was submitted is done.
  void waitIdle();

  /// Messages of the validation layer since the start; a test expects none.
  std::vector<std::string> validationMessages() const;

  /// A memory type that has all of `wanted`, preferably `preferred` too.
  std::uint32_t memoryType(std::uint32_t type_bits, VkMemoryPropertyFlags wanted,
                           VkMemoryPropertyFlags preferred) const;

  // --- live buffers, by device address: the recorder finds the buffer that a pointer points into ---
  struct LiveBuffer {
    std::uint64_t bytes = 0;           ///< without guards
    unsigned char* guarded = nullptr;  ///< mapped memory including guards; null when not mapped
  };
  void addLiveBuffer(std::uint64_t address, const LiveBuffer& buffer);
  void removeLiveBuffer(std::uint64_t address);
  /// The first address of the live buffer that holds `address`; 0 when there is none.
  std::uint64_t liveBufferAt(std::uint64_t address) const;
  /// How many live buffers have had their guard words overwritten.
  int damagedGuards() const;
  bool guards() const { return guards_; }

  static constexpr std::uint32_t kGuardBytes = 256;  ///< a multiple of every alignment that we use
  static constexpr unsigned char kGuardByte = 0xA5;

 private:
  struct Empty {};
  explicit Gpu(Empty) {}  // delegated to, so that a constructor that throws still destroys what it made
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
  std::mutex ends_mutex_;  ///< of the two that follow
  Clock::time_point last_end_{};
  double longest_submission_s_ = 0;
  ValidationMessages messages_;
  mutable std::mutex live_buffers_mutex_;
  std::map<std::uint64_t, LiveBuffer> live_buffers_;
};

/// \throw Error (Fault::kDevice) unless `result` is success; `doing` completes "could not …".
void check(VkResult result, const char* doing);

}  // namespace airclay
