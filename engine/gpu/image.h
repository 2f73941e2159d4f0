// SPDX-License-Identifier: MIT
// An image in device memory that can be drawn into, owned by value.
#pragma once

#include "engine/gpu/buffer.h"
#include "engine/gpu/recorder.h"

namespace airclay {

enum class ImageKind {
  kColor,   ///< 8 bits per channel, red first; shaders write linear light, memory and copies are sRGB
  kScreen,  ///< the same, blue first, as a window's swapchain image: a plain copy suffices
  kDepth,   ///< 32-bit float, 0 near, 1 far
};

VkFormat formatOf(ImageKind kind);

/// A view of a 2D image, whoever owns it.
VkImageView makeImageView(Gpu& gpu, VkImage image, VkFormat format, VkImageAspectFlags aspect);
/// Records a barrier and layout transition. Everything before it completes, and all later commands see the
/// results.
void recordLayout(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect, VkImageLayout from,
                  VkImageLayout to);

/// Samples per pixel: the most that every Vulkan device supports.
inline constexpr std::uint32_t kSamples = 4;

/// One image and its view. The layout is tracked as commands are recorded, so command buffers that use it
/// must be submitted in the order in which they were recorded.
class Image {
 public:
  Image() = default;
  /// \throw Error (Fault::kDevice) when the device cannot hold an image this large.
  Image(Gpu& gpu, ImageKind kind, std::uint32_t width, std::uint32_t height, std::uint32_t samples = 1);
  Image(Image&& other) noexcept { swap(other); }
  Image& operator=(Image&& other) noexcept {
    swap(other);
    return *this;
  }
  ~Image();

  ImageKind kind() const { return kind_; }
  std::uint32_t width() const { return width_; }    ///< pixels
  std::uint32_t height() const { return height_; }  ///< pixels
  std::uint32_t samples() const { return samples_; }
  VkImage handle() const { return image_; }
  VkImageView view() const { return view_; }

  /// Records the transition from the image's last use to `layout`: always a barrier, since images are used
  /// only a few times per frame. `keep`: preserve the content.
  void transition(VkCommandBuffer commands, VkImageLayout layout, bool keep);

 private:
  void swap(Image& other) noexcept;
  VkImageAspectFlags aspect() const;

  Gpu* gpu_ = nullptr;
  ImageKind kind_ = ImageKind::kColor;
  std::uint32_t width_ = 0, height_ = 0, samples_ = 1;
  VkImage image_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  VkImageView view_ = VK_NULL_HANDLE;
  VkImageLayout layout_ = VK_IMAGE_LAYOUT_UNDEFINED;

  friend void copyImage(Recorder& recorder, Image& from, Image& to);
  friend void copyToBuffer(Recorder& recorder, Image& image, const RawBuffer& buffer, std::uint64_t offset);
};

/// Copies a single-sample image to another of the same kind and size.
void copyImage(Recorder& recorder, Image& from, Image& to);

/// Copies a single-sample image to `buffer` at byte `offset`: 4 bytes per pixel (red first, or a depth), row
/// by row from the top, no padding.
void copyToBuffer(Recorder& recorder, Image& image, const RawBuffer& buffer, std::uint64_t offset = 0);

}  // namespace airclay
