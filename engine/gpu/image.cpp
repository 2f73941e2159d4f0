// SPDX-License-Identifier: MIT
#include "engine/gpu/image.h"

#include <utility>

#include "engine/core/error.h"

namespace airclay {

VkFormat formatOf(ImageKind kind) {
  switch (kind) {
    case ImageKind::kColor:
      return VK_FORMAT_R8G8B8A8_SRGB;
    case ImageKind::kScreen:
      return VK_FORMAT_B8G8R8A8_SRGB;
    case ImageKind::kDepth:
      break;
  }
  return VK_FORMAT_D32_SFLOAT;
}

VkImageView makeImageView(Gpu& gpu, VkImage image, VkFormat format, VkImageAspectFlags aspect) {
  VkImageViewCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
  info.image = image;
  info.viewType = VK_IMAGE_VIEW_TYPE_2D;
  info.format = format;
  info.subresourceRange = {aspect, 0, 1, 0, 1};
  VkImageView view = VK_NULL_HANDLE;
  check(vkCreateImageView(gpu.device(), &info, nullptr, &view), "create an image view");
  return view;
}

void recordLayout(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect, VkImageLayout from,
                  VkImageLayout to) {
  VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
  barrier.srcStageMask = barrier.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  barrier.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
  barrier.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
  barrier.oldLayout = from;
  barrier.newLayout = to;
  barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  barrier.image = image;
  barrier.subresourceRange = {aspect, 0, 1, 0, 1};
  VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  dependency.imageMemoryBarrierCount = 1;
  dependency.pImageMemoryBarriers = &barrier;
  vkCmdPipelineBarrier2(commands, &dependency);
}

Image::Image(Gpu& gpu, ImageKind kind, std::uint32_t width, std::uint32_t height, std::uint32_t samples)
    : Image() {  // delegated to, so that what was created is destroyed if this throws
  gpu_ = &gpu;
  kind_ = kind;
  width_ = width;
  height_ = height;
  samples_ = samples;
  const std::uint32_t most = gpu.limits().maxImageDimension2D;
  if (width == 0 || height == 0 || width > most || height > most)
    throw Error("an image of " + std::to_string(width) + " x " + std::to_string(height) +
                    " pixels cannot be drawn on " + gpu.info().name + "; 1 to " + std::to_string(most) +
                    " along each side is allowed",
                Fault::kDevice);
  VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
  info.imageType = VK_IMAGE_TYPE_2D;
  info.format = formatOf(kind);
  info.extent = {width, height, 1};
  info.mipLevels = info.arrayLayers = 1;
  info.samples = static_cast<VkSampleCountFlagBits>(samples);
  const bool is_depth = kind == ImageKind::kDepth;
  if (!is_depth && samples == 1) {
    // bytes for copies, an sRGB view for drawing
    info.format = kind == ImageKind::kColor ? VK_FORMAT_R8G8B8A8_UNORM : VK_FORMAT_B8G8R8A8_UNORM;
    info.flags = VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT;
  }
  info.usage = is_depth ? VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT : VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
  if (samples == 1) info.usage |= VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  check(vkCreateImage(gpu.device(), &info, nullptr, &image_), "create an image");

  VkMemoryRequirements requirements;
  vkGetImageMemoryRequirements(gpu.device(), image_, &requirements);
  VkMemoryAllocateInfo allocation{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
  allocation.allocationSize = requirements.size;
  allocation.memoryTypeIndex =
      gpu.memoryType(requirements.memoryTypeBits, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, 0);
  check(vkAllocateMemory(gpu.device(), &allocation, nullptr, &memory_), "allocate memory for an image");
  check(vkBindImageMemory(gpu.device(), image_, memory_, 0), "bind an image to its memory");

  view_ = makeImageView(gpu, image_, formatOf(kind), aspect());
}

Image::~Image() {
  if (!gpu_) return;
  vkDestroyImageView(gpu_->device(), view_, nullptr);
  vkDestroyImage(gpu_->device(), image_, nullptr);
  vkFreeMemory(gpu_->device(), memory_, nullptr);
}

void Image::swap(Image& other) noexcept {
  std::swap(gpu_, other.gpu_);
  std::swap(kind_, other.kind_);
  std::swap(width_, other.width_);
  std::swap(height_, other.height_);
  std::swap(samples_, other.samples_);
  std::swap(image_, other.image_);
  std::swap(memory_, other.memory_);
  std::swap(view_, other.view_);
  std::swap(layout_, other.layout_);
}

VkImageAspectFlags Image::aspect() const {
  return kind_ == ImageKind::kDepth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
}

void Image::transition(VkCommandBuffer commands, VkImageLayout layout, bool keep) {
  recordLayout(commands, image_, aspect(), keep ? layout_ : VK_IMAGE_LAYOUT_UNDEFINED, layout);
  layout_ = layout;
}

void copyImage(Recorder& recorder, Image& from, Image& to) {
  if (from.kind() != to.kind() || from.width() != to.width() || from.height() != to.height())
    throw Error("source and destination of an image copy differ in kind or size", Fault::kDevice);
  VkCommandBuffer commands = recorder.commandsFor("copy image", {});
  from.transition(commands, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, true);
  to.transition(commands, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, false);
  VkImageCopy region{};
  region.srcSubresource = region.dstSubresource = {from.aspect(), 0, 0, 1};
  region.extent = {from.width(), from.height(), 1};
  vkCmdCopyImage(commands, from.handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to.handle(),
                 VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
}

void copyToBuffer(Recorder& recorder, Image& image, const RawBuffer& buffer, std::uint64_t offset) {
  if (offset + 4ull * image.width() * image.height() > buffer.bytes())
    throw Error("the destination buffer of an image copy is too small", Fault::kDevice);
  VkCommandBuffer commands = recorder.commandsFor("copy image", {{buffer.address(), false, true}});
  image.transition(commands, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, true);
  VkBufferImageCopy region{};
  region.bufferOffset = buffer.offset() + offset;
  region.imageSubresource = {image.aspect(), 0, 0, 1};
  region.imageExtent = {image.width(), image.height(), 1};
  vkCmdCopyImageToBuffer(commands, image.handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, buffer.handle(), 1,
                         &region);
}

}  // namespace airclay
