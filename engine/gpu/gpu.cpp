// SPDX-License-Identifier: MIT
#include "engine/gpu/gpu.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "engine/core/error.h"

namespace airclay {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

/// The features that the engine uses, chained for a query or for device creation.
struct Features {
  VkPhysicalDeviceVulkan13Features v13{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
  VkPhysicalDeviceVulkan12Features v12{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
  VkPhysicalDeviceFeatures2 core{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};

  Features() {
    core.pNext = &v12;
    v12.pNext = &v13;
  }
  Features(const Features&) = delete;
  Features& operator=(const Features&) = delete;
};

struct RequiredFeature {
  const char* name;
  VkBool32& (*flag)(Features&);
};

/// All required features, by name; the query, the device creation and the message share this list.
const RequiredFeature kRequired[] = {
    {"bufferDeviceAddress", [](Features& f) -> VkBool32& { return f.v12.bufferDeviceAddress; }},
    {"scalarBlockLayout", [](Features& f) -> VkBool32& { return f.v12.scalarBlockLayout; }},
    {"synchronization2", [](Features& f) -> VkBool32& { return f.v13.synchronization2; }},
    {"dynamicRendering", [](Features& f) -> VkBool32& { return f.v13.dynamicRendering; }},
    {"maintenance4", [](Features& f) -> VkBool32& { return f.v13.maintenance4; }},
    {"shaderInt64", [](Features& f) -> VkBool32& { return f.core.features.shaderInt64; }},
    {"shaderClipDistance", [](Features& f) -> VkBool32& { return f.core.features.shaderClipDistance; }},
    // the solve is in double precision: float normal equations lose 1e-5 at the condition numbers met here
    {"shaderFloat64", [](Features& f) -> VkBool32& { return f.core.features.shaderFloat64; }},
};

const char* typeName(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return "discrete";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return "integrated";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return "virtual";
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      return "cpu";
    default:
      return "other";
  }
}

/// Higher is better: a hardware GPU before a software one.
int rank(const std::string& type) {
  if (type == "discrete") return 4;
  if (type == "integrated") return 3;
  if (type == "virtual") return 2;
  return type == "cpu" ? 1 : 0;
}

std::vector<VkPhysicalDevice> physicalDevices(VkInstance instance) {
  std::uint32_t count = 0;
  check(vkEnumeratePhysicalDevices(instance, &count, nullptr), "list the Vulkan devices");
  std::vector<VkPhysicalDevice> devices(count);
  check(vkEnumeratePhysicalDevices(instance, &count, devices.data()), "list the Vulkan devices");
  return devices;
}

/// The queue family that supports compute, graphics and timestamps; -1 if there is none.
int computeAndGraphicsFamily(VkPhysicalDevice device) {
  std::uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
  constexpr VkQueueFlags required = VK_QUEUE_COMPUTE_BIT | VK_QUEUE_GRAPHICS_BIT;
  for (std::uint32_t i = 0; i < count; ++i)
    if ((families[i].queueFlags & required) == required && families[i].timestampValidBits > 0)
      return static_cast<int>(i);
  return -1;
}

DeviceInfo describe(VkPhysicalDevice device) {
  VkPhysicalDeviceSubgroupProperties subgroup{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
  VkPhysicalDeviceDriverProperties driver{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
  properties.pNext = &driver;
  driver.pNext = &subgroup;
  vkGetPhysicalDeviceProperties2(device, &properties);

  DeviceInfo info;
  info.name = properties.properties.deviceName;
  info.type = typeName(properties.properties.deviceType);
  info.driver = std::string(driver.driverName) + " " + driver.driverInfo;
  info.api_version = properties.properties.apiVersion;
  VkPhysicalDeviceMemoryProperties memory;
  vkGetPhysicalDeviceMemoryProperties(device, &memory);
  for (std::uint32_t i = 0; i < memory.memoryHeapCount; ++i)
    if (memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT)
      info.memory_bytes = std::max<std::uint64_t>(info.memory_bytes, memory.memoryHeaps[i].size);

  if (info.api_version < VK_API_VERSION_1_3) {
    info.missing.push_back("Vulkan 1.3");
    return info;  // the driver may not know its feature structs
  }
  Features features;
  vkGetPhysicalDeviceFeatures2(device, &features.core);
  for (const RequiredFeature& required : kRequired)
    if (!required.flag(features)) info.missing.push_back(required.name);
  constexpr VkSubgroupFeatureFlags operations =
      VK_SUBGROUP_FEATURE_BASIC_BIT | VK_SUBGROUP_FEATURE_ARITHMETIC_BIT | VK_SUBGROUP_FEATURE_BALLOT_BIT;
  if ((subgroup.supportedOperations & operations) != operations ||
      !(subgroup.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT))
    info.missing.push_back("subgroup arithmetic and ballots in compute shaders");
  if (computeAndGraphicsFamily(device) < 0)
    info.missing.push_back("a queue for compute and graphics with timestamps");
  return info;
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

VKAPI_ATTR VkBool32 VKAPI_CALL collectMessage(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                              VkDebugUtilsMessageTypeFlagsEXT,
                                              const VkDebugUtilsMessengerCallbackDataEXT* data,
                                              void* user_data) {
  auto& messages = *static_cast<ValidationMessages*>(user_data);
  const std::lock_guard lock(messages.mutex);
  messages.texts.push_back(data->pMessage);
  return VK_FALSE;
}

VkDebugUtilsMessengerCreateInfoEXT messengerInfo(ValidationMessages* messages) {
  VkDebugUtilsMessengerCreateInfoEXT info{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
  info.messageSeverity =
      VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
  info.pfnUserCallback = collectMessage;
  info.pUserData = messages;
  return info;
}

VkInstance makeInstance(bool validation, ValidationMessages* messages) {
  // Mesa's implicit device-select layer asks the display which device it uses, and complains on standard
  // error if there is no display; --device chooses the device.
  setenv("NODEVICE_SELECT", "1", 0);
  VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
  application.pApplicationName = "Airclay";
  application.apiVersion = VK_API_VERSION_1_3;

  const VkValidationFeatureEnableEXT enabled[] = {
      VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
  VkValidationFeaturesEXT features{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT};
  features.enabledValidationFeatureCount = 1;
  features.pEnabledValidationFeatures = enabled;
  VkDebugUtilsMessengerCreateInfoEXT messenger = messengerInfo(messages);
  messenger.pNext = &features;

  std::vector<const char*> extensions;
  VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
  info.pApplicationInfo = &application;
  if (validation) {
    extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    info.pNext = &messenger;
    info.enabledLayerCount = 1;
    info.ppEnabledLayerNames = &kValidationLayer;
  }
  // the extensions that a window needs, if the loader has them
  std::uint32_t count = 0;
  vkEnumerateInstanceExtensionProperties(nullptr, &count, nullptr);
  std::vector<VkExtensionProperties> available(count);
  vkEnumerateInstanceExtensionProperties(nullptr, &count, available.data());
  for (const char* surface :
       {"VK_KHR_surface", "VK_KHR_xcb_surface", "VK_KHR_xlib_surface", "VK_KHR_wayland_surface"})
    for (const VkExtensionProperties& extension : available)
      if (std::strcmp(extension.extensionName, surface) == 0) extensions.push_back(surface);
  info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();

  VkInstance instance = VK_NULL_HANDLE;
  const VkResult result = vkCreateInstance(&info, nullptr, &instance);
  if (result == VK_ERROR_LAYER_NOT_PRESENT)
    throw Error(
        "the Vulkan validation layer is not installed; install vulkan-validationlayers, or run without it",
        Fault::kDevice);
  if (result != VK_SUCCESS)
    throw Error(
        "no usable Vulkan driver (vkCreateInstance failed); install mesa-vulkan-drivers for the software "
        "device",
        Fault::kDevice);
  return instance;
}

}  // namespace

void check(VkResult result, const char* doing) {
  if (result == VK_SUCCESS) return;
  const std::string could_not = std::string("could not ") + doing + ": ";
  switch (result) {
    case VK_ERROR_DEVICE_LOST:
      throw Error(could_not + "the Vulkan device was lost (a driver reset, or unplugged); start again",
                  Fault::kDevice);
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
    case VK_ERROR_OUT_OF_HOST_MEMORY:
      throw Error(could_not + "out of memory on the Vulkan device; use fewer voxels or a lower level",
                  Fault::kDevice);
    default:
      throw Error(could_not + "Vulkan error " + std::to_string(result), Fault::kDevice);
  }
}

std::vector<DeviceInfo> Gpu::devices() {
  ValidationMessages unused;
  const VkInstance instance = makeInstance(false, &unused);
  std::vector<DeviceInfo> infos;
  for (VkPhysicalDevice device : physicalDevices(instance)) infos.push_back(describe(device));
  vkDestroyInstance(instance, nullptr);
  return infos;
}

Gpu::Gpu(const GpuOptions& options) : Gpu(Empty{}) {
  guards_ = options.guards;
  createInstance(options.validation);
  const std::vector<VkPhysicalDevice> candidates = physicalDevices(instance_);
  if (candidates.empty())
    throw Error("no Vulkan device found; install mesa-vulkan-drivers for the software device",
                Fault::kDevice);

  const bool by_index =
      !options.device.empty() && options.device.find_first_not_of("0123456789") == std::string::npos;
  std::vector<std::string> names;
  int best = -1;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const DeviceInfo info = describe(candidates[i]);
    names.push_back(std::to_string(i) + " " + info.name);
    const bool required =
        options.device.empty() || (by_index ? options.device == std::to_string(i)
                                            : info.name.find(options.device) != std::string::npos);
    if (!required) continue;
    if (!info.missing.empty()) {
      if (!options.device.empty())
        throw Error("device " + info.name + " lacks " + joined(info.missing), Fault::kDevice);
      continue;
    }
    if (best < 0 || rank(info.type) > rank(info_.type)) {
      best = static_cast<int>(i);
      info_ = info;
    }
  }
  if (best < 0) {
    if (!options.device.empty())
      throw Error("no Vulkan device '" + options.device + "'; there are: " + joined(names), Fault::kDevice);
    throw Error("no Vulkan device has all required features; `airclay devices` lists what each lacks",
                Fault::kDevice);
  }
  physical_device_ = candidates[static_cast<std::size_t>(best)];
  createDevice();
}

void Gpu::createInstance(bool validation) {
  instance_ = makeInstance(validation, &messages_);
  if (!validation) return;
  const auto create = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
      vkGetInstanceProcAddr(instance_, "vkCreateDebugUtilsMessengerEXT"));
  const VkDebugUtilsMessengerCreateInfoEXT info = messengerInfo(&messages_);
  check(create(instance_, &info, nullptr, &messenger_), "register the validation callback");
}

void Gpu::createDevice() {
  is_cpu_ = info_.type == "cpu";
  VkPhysicalDeviceSubgroupProperties subgroup{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
  properties.pNext = &subgroup;
  vkGetPhysicalDeviceProperties2(physical_device_, &properties);
  subgroup_size_ = subgroup.subgroupSize;
  limits_ = properties.properties.limits;
  vkGetPhysicalDeviceMemoryProperties(physical_device_, &memory_);

  Features features;
  for (const RequiredFeature& required : kRequired) required.flag(features) = VK_TRUE;
  queue_family_ = static_cast<std::uint32_t>(computeAndGraphicsFamily(physical_device_));
  const float priority = 1;
  VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
  queue.queueFamilyIndex = queue_family_;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;

  std::uint32_t count = 0;
  vkEnumerateDeviceExtensionProperties(physical_device_, nullptr, &count, nullptr);
  std::vector<VkExtensionProperties> available(count);
  vkEnumerateDeviceExtensionProperties(physical_device_, nullptr, &count, available.data());
  std::vector<const char*> extensions;
  for (const VkExtensionProperties& extension : available)
    if (std::strcmp(extension.extensionName, VK_KHR_SWAPCHAIN_EXTENSION_NAME) == 0)
      extensions.push_back(VK_KHR_SWAPCHAIN_EXTENSION_NAME);

  VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
  info.pNext = &features.core;
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  check(vkCreateDevice(physical_device_, &info, nullptr, &device_), "open the Vulkan device");
  vkGetDeviceQueue(device_, queue_family_, 0, &queue_);
}

Gpu::~Gpu() {
  if (device_) vkDestroyDevice(device_, nullptr);
  if (messenger_) {
    const auto destroy = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT"));
    destroy(instance_, messenger_, nullptr);
  }
  if (instance_) vkDestroyInstance(instance_, nullptr);
}

std::uint32_t Gpu::memoryType(std::uint32_t type_bits, VkMemoryPropertyFlags required,
                              VkMemoryPropertyFlags preferred) const {
  for (const VkMemoryPropertyFlags flags : {required | preferred, required})
    for (std::uint32_t i = 0; i < memory_.memoryTypeCount; ++i)
      if ((type_bits >> i & 1) && (memory_.memoryTypes[i].propertyFlags & flags) == flags) return i;
  throw Error("the Vulkan device has no suitable memory type", Fault::kDevice);
}

void Gpu::submit(VkCommandBuffer commands, VkFence fence, const VkSemaphoreSubmitInfo* wait,
                 const VkSemaphoreSubmitInfo* signal) {
  VkCommandBufferSubmitInfo buffer{VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO};
  buffer.commandBuffer = commands;
  VkSubmitInfo2 info{VK_STRUCTURE_TYPE_SUBMIT_INFO_2};
  info.commandBufferInfoCount = 1;
  info.pCommandBufferInfos = &buffer;
  info.waitSemaphoreInfoCount = wait ? 1 : 0;
  info.pWaitSemaphoreInfos = wait;
  info.signalSemaphoreInfoCount = signal ? 1 : 0;
  info.pSignalSemaphoreInfos = signal;
  const std::lock_guard lock(queue_mutex_);
  check(vkQueueSubmit2(queue_, 1, &info, fence), "submit work");
}

void Gpu::noteEnd(Clock::time_point submitted) {
  const auto now = Clock::now();
  const std::lock_guard lock(ends_mutex_);
  // measured from the end of another submission, if it waited for that one in the queue
  const auto began = std::max(submitted, last_end_);
  longest_submission_s_ = std::max(longest_submission_s_, secondsBetween(began, now));
  last_end_ = now;
}

double Gpu::takeLongestSubmissionMs() {
  const std::lock_guard lock(ends_mutex_);
  return 1000 * std::exchange(longest_submission_s_, 0.0);
}

void Gpu::waitIdle() {
  const std::lock_guard lock(queue_mutex_);
  check(vkQueueWaitIdle(queue_), "wait for the device");
}

std::vector<std::string> Gpu::validationMessages() const {
  const std::lock_guard lock(messages_.mutex);
  return messages_.texts;
}

void Gpu::addLiveBuffer(std::uint64_t address, const LiveBuffer& buffer) {
  const std::lock_guard lock(live_buffers_mutex_);
  live_buffers_[address] = buffer;
}

void Gpu::removeLiveBuffer(std::uint64_t address) {
  const std::lock_guard lock(live_buffers_mutex_);
  live_buffers_.erase(address);
}

std::uint64_t Gpu::liveBufferAt(std::uint64_t address) const {
  const std::lock_guard lock(live_buffers_mutex_);
  auto after = live_buffers_.upper_bound(address);
  if (after == live_buffers_.begin()) return 0;
  const auto& [start, buffer] = *std::prev(after);
  return address < start + buffer.bytes ? start : 0;
}

int Gpu::damagedGuards() const {
  const std::lock_guard lock(live_buffers_mutex_);
  int damaged = 0;
  for (const auto& [address, buffer] : live_buffers_) {
    if (!guards_ || !buffer.guarded) continue;
    const unsigned char* before = buffer.guarded;
    const unsigned char* behind = buffer.guarded + kGuardBytes + buffer.bytes;
    const auto whole = [](unsigned char byte) { return byte == kGuardByte; };
    if (!std::all_of(before, before + kGuardBytes, whole) ||
        !std::all_of(behind, behind + kGuardBytes, whole))
      ++damaged;
  }
  return damaged;
}

}  // namespace airclay
