// SPDX-License-Identifier: MIT
// A typed array in the device's memory, owned by value.
#pragma once

#include <cstring>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine/gpu/gpu.h"
#include "shaders/core/io.h"

namespace airclay {

/// Where a buffer is allocated.
enum class Memory {
  kDevice,  ///< fastest for kernels; written and read by the host through upload() and download()
  kHost,    ///< mapped: host() is the memory that kernels use (incoming frames, outgoing results)
};

/// The untyped part of Buffer<T>. One allocation per buffer: the engine has dozens of buffers, not thousands.
class RawBuffer {
 public:
  RawBuffer() = default;
  RawBuffer(Gpu& gpu, std::uint64_t bytes, Memory memory);
  RawBuffer(RawBuffer&& other) noexcept { swap(other); }
  RawBuffer& operator=(RawBuffer&& other) noexcept {
    swap(other);
    return *this;
  }
  ~RawBuffer();

  std::uint64_t address() const { return address_; }
  std::uint64_t bytes() const { return bytes_; }
  VkBuffer handle() const { return buffer_; }
  /// Offset of this buffer's first byte in handle().
  std::uint64_t offset() const { return offset_; }
  unsigned char* mapped() const { return mapped_ ? mapped_ + offset_ : nullptr; }

  /// Copies through the mapping, or through a staging buffer and a submission of its own. Not for use in
  /// every frame.
  void upload(const void* data, std::uint64_t bytes);
  void download(void* data, std::uint64_t bytes) const;

 private:
  void swap(RawBuffer& other) noexcept;
  void copyThroughStaging(VkBuffer from, VkBuffer to, std::uint64_t from_offset, std::uint64_t to_offset,
                          std::uint64_t bytes) const;

  Gpu* gpu_ = nullptr;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  std::uint64_t address_ = 0, bytes_ = 0, offset_ = 0;
  unsigned char* mapped_ = nullptr;
};

/// `count` values of T. Never empty: a count of 0 allocates one value, so that the address is valid.
template <class T>
class Buffer {
  static_assert(std::is_standard_layout_v<T>, "a buffer's values are copied as bytes");

 public:
  Buffer() = default;
  Buffer(Gpu& gpu, std::size_t count, Memory memory = Memory::kDevice)
      : raw_(gpu, std::max<std::size_t>(count, 1) * sizeof(T), memory), count_(count) {}
  Buffer(Gpu& gpu, std::span<const T> values, Memory memory = Memory::kDevice)
      : Buffer(gpu, values.size(), memory) {
    upload(values);
  }
  Buffer(Gpu& gpu, const std::vector<T>& values, Memory memory = Memory::kDevice)
      : Buffer(gpu, std::span<const T>(values), memory) {}

  std::size_t count() const { return count_; }
  const RawBuffer& raw() const { return raw_; }

  /// \pre created with Memory::kHost
  std::span<T> host() { return {reinterpret_cast<T*>(raw_.mapped()), count_}; }
  std::span<const T> host() const { return {reinterpret_cast<const T*>(raw_.mapped()), count_}; }

  void upload(std::span<const T> values) { raw_.upload(values.data(), values.size_bytes()); }
  std::vector<T> download() const {
    std::vector<T> values(count_);
    raw_.download(values.data(), count_ * sizeof(T));
    return values;
  }

  /// The address of element `index`, for a kernel's arguments.
  DevicePointer<T> at(std::size_t index) const { return {raw_.address() + index * sizeof(T)}; }
  operator DevicePointer<T>() const { return {raw_.address()}; }
  operator DevicePointer<const T>() const { return {raw_.address()}; }

 private:
  RawBuffer raw_;
  std::size_t count_ = 0;
};

}  // namespace airclay
