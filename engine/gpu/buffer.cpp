// SPDX-License-Identifier: MIT
#include "engine/gpu/buffer.h"

#include "engine/core/error.h"
#include "engine/gpu/one_time.h"

namespace airclay {

RawBuffer::RawBuffer(Gpu& gpu, std::uint64_t bytes, Memory memory) : gpu_(&gpu), bytes_(bytes) {
  offset_ = gpu.guards() ? Gpu::kGuardBytes : 0;
  VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  info.size = bytes + 2 * offset_;
  info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
               VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
               VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | VK_BUFFER_USAGE_INDEX_BUFFER_BIT;
  check(vkCreateBuffer(gpu.device(), &info, nullptr, &buffer_), "create a buffer");

  VkMemoryRequirements requirements;
  vkGetBufferMemoryRequirements(gpu.device(), buffer_, &requirements);
  constexpr VkMemoryPropertyFlags mapped =
      VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  // software devices map everything; others only what the host touches every frame
  const bool map = memory == Memory::kHost || gpu.isCpu();
  VkMemoryAllocateFlagsInfo flags{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO};
  flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
  VkMemoryAllocateInfo allocation{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
  allocation.pNext = &flags;
  allocation.allocationSize = requirements.size;
  allocation.memoryTypeIndex =
      map ? gpu.memoryType(requirements.memoryTypeBits, mapped, VK_MEMORY_PROPERTY_HOST_CACHED_BIT)
          : gpu.memoryType(requirements.memoryTypeBits, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, 0);
  check(vkAllocateMemory(gpu.device(), &allocation, nullptr, &memory_), "allocate memory for a buffer");
  check(vkBindBufferMemory(gpu.device(), buffer_, memory_, 0), "bind a buffer to its memory");
  if (map) {
    void* pointer = nullptr;
    check(vkMapMemory(gpu.device(), memory_, 0, VK_WHOLE_SIZE, 0, &pointer), "map a buffer");
    mapped_ = static_cast<unsigned char*>(pointer);
    if (gpu.guards()) std::memset(mapped_, Gpu::kGuardByte, static_cast<std::size_t>(info.size));
    std::memset(mapped_ + offset_, 0, static_cast<std::size_t>(bytes));
  }
  VkBufferDeviceAddressInfo address{VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO};
  address.buffer = buffer_;
  address_ = vkGetBufferDeviceAddress(gpu.device(), &address) + offset_;
  gpu.addLiveBuffer(address_, {bytes, mapped_});
}

RawBuffer::~RawBuffer() {
  if (!gpu_) return;
  gpu_->removeLiveBuffer(address_);
  vkDestroyBuffer(gpu_->device(), buffer_, nullptr);
  vkFreeMemory(gpu_->device(), memory_, nullptr);
}

void RawBuffer::swap(RawBuffer& other) noexcept {
  std::swap(gpu_, other.gpu_);
  std::swap(buffer_, other.buffer_);
  std::swap(memory_, other.memory_);
  std::swap(address_, other.address_);
  std::swap(bytes_, other.bytes_);
  std::swap(offset_, other.offset_);
  std::swap(mapped_, other.mapped_);
}

void RawBuffer::copyThroughStaging(VkBuffer from, VkBuffer to, std::uint64_t from_offset,
                                   std::uint64_t to_offset, std::uint64_t bytes) const {
  submitOnce(*gpu_, [&](VkCommandBuffer commands) {
    const VkBufferCopy region{from_offset, to_offset, bytes};
    vkCmdCopyBuffer(commands, from, to, 1, &region);
  });
}

void RawBuffer::upload(const void* data, std::uint64_t bytes) {
  if (bytes > bytes_) throw Error("an upload is larger than its buffer", Fault::kDevice);
  if (bytes == 0) return;
  if (mapped_) {
    std::memcpy(mapped(), data, static_cast<std::size_t>(bytes));
    return;
  }
  RawBuffer staging(*gpu_, bytes, Memory::kHost);
  std::memcpy(staging.mapped(), data, static_cast<std::size_t>(bytes));
  copyThroughStaging(staging.buffer_, buffer_, staging.offset_, offset_, bytes);
}

void RawBuffer::download(void* data, std::uint64_t bytes) const {
  if (bytes > bytes_) throw Error("a download is larger than its buffer", Fault::kDevice);
  if (bytes == 0) return;
  if (mapped_) {
    std::memcpy(data, mapped(), static_cast<std::size_t>(bytes));
    return;
  }
  RawBuffer staging(*gpu_, bytes, Memory::kHost);
  copyThroughStaging(buffer_, staging.buffer_, offset_, staging.offset_, bytes);
  std::memcpy(data, staging.mapped(), static_cast<std::size_t>(bytes));
}

}  // namespace airclay
