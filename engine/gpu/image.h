// SPDX-License-Identifier: MIT
// An image in the device's memory that is drawn into, owned by value.
#pragma once

#include "engine/gpu/buffer.h"
#include "engine/gpu/recorder.h"

namespace airclay {

enum class ImageKind {
  kColor,   ///< 8 bits a channel, red first; shaders write linear light, memory and copies hold sRGB
  kScreen,  ///< the same, blue first: what a window's image is a plain copy of
  kDepth,   ///< 32-bit float, 0 near, 1 far
};

VkFormat formatOf(ImageKind kind);

/// A view of a plane image, whoever owns it.
VkImageView makeImageView(Gpu& gpu, VkImage image, VkFormat format, VkImageAspectFlags aspect);
/// Records a barrier that also takes an image from one layout to another. Everything before is done then, and
/// all of it can be read.
void recordLayout(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect, VkImageLayout from,
                  VkImageLayout to);

/// Edges are drawn with this many samples a pixel: the most that every Vulkan device has.
inline constexpr std::uint32_t kSamples = 4;

/// One image and its view. Its layout is followed as commands are recorded, so commands that use it must be
/// submitted in the order in which they were recorded.
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

  /// Records what must stand between the image's last use and one in `layout`: always a barrier, for images
  /// are used a few times a frame. `keep`: the content is still wanted.
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

/// Copies an image of one sample to another of the same kind and size.
void copyImage(Recorder& recorder, Image& from, Image& to);

/// Copies an image of one sample to `buffer`, `offset` bytes on: 4 bytes a pixel (red first, or a depth),
/// row by row from the top, no padding.
void copyToBuffer(Recorder& recorder, Image& image, const RawBuffer& buffer, std::uint64_t offset = 0);

}  // namespace airclay
