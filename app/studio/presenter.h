// SPDX-License-Identifier: MIT
// Presents a window's images: by a swapchain, or on a software device through memory shared with the X
// server.
#pragma once

#include <optional>

#include "engine/gpu/recorder.h"

namespace airclay {

class Presenter {
 public:
  explicit Presenter(Gpu& gpu) : gpu_(gpu) {}
  virtual ~Presenter();
  Presenter(const Presenter&) = delete;
  Presenter& operator=(const Presenter&) = delete;

  virtual const char* name() const = 0;
  /// Dear ImGui's render pass over the existing image: from the attachment layout to shownLayout().
  VkRenderPass renderPass() const { return render_pass_; }
  VkExtent2D extent() const { return extent_; }  ///< pixels
  /// The layout that the image must have on submission.
  virtual VkImageLayout shownLayout() const = 0;
  virtual std::uint32_t imageCount() const = 0;

  /// Call it when the window's size in pixels changes. Waits for pending drawing.
  virtual void resize(std::uint32_t width, std::uint32_t height) = 0;

  struct Target {
    VkImage image = VK_NULL_HANDLE;
    VkFramebuffer framebuffer = VK_NULL_HANDLE;
  };
  /// The next image to draw into; null if the window has changed: call resize() and retry. \pre the last
  /// image has been shown
  virtual std::optional<Target> acquire() = 0;
  /// Submits `recorder`, which draws the target, without waiting for it.
  virtual void submit(Recorder& recorder, const Target& target) = 0;
  /// Shows the submitted image and waits for the device. False if the window has changed.
  virtual bool show(Recorder& recorder, const Target& target) = 0;

 protected:
  /// UNORM, not SRGB: the engine's images and the interface's colors are sRGB-encoded already.
  static constexpr VkFormat kFormat = VK_FORMAT_B8G8R8A8_UNORM;

  /// \pre shownLayout() may be called
  void makeRenderPass();
  VkFramebuffer makeFramebuffer(VkImageView view) const;

  Gpu& gpu_;
  VkRenderPass render_pass_ = VK_NULL_HANDLE;
  VkExtent2D extent_{};
};

}  // namespace airclay
