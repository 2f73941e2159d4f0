// SPDX-License-Identifier: MIT
// Where a window's images are drawn and how they come to the display: by a swapchain, or on a software
// device through memory that the X server shares.
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
  /// Dear ImGui's, over what is there: from the layout of an attachment to shownLayout().
  VkRenderPass renderPass() const { return render_pass_; }
  VkExtent2D extent() const { return extent_; }  ///< pixels
  /// How its image must be laid out when it is submitted.
  virtual VkImageLayout shownLayout() const = 0;
  virtual std::uint32_t imageCount() const = 0;

  /// The window has another size, in pixels. Waits for what is being drawn.
  virtual void resize(std::uint32_t width, std::uint32_t height) = 0;

  struct Target {
    std::uint32_t index = 0;
    VkImage image = VK_NULL_HANDLE;
    VkFramebuffer framebuffer = VK_NULL_HANDLE;
  };
  /// The next image to draw into; none when the window has changed: resize(), and ask again. \pre the last
  /// image has been shown
  virtual std::optional<Target> acquire() = 0;
  /// Submits what `recorder` has, which draws the target; returns without waiting for it.
  virtual void submit(Recorder& recorder, const Target& target) = 0;
  /// Shows what was submitted, and waits for the device. False when the window has changed.
  virtual bool show(Recorder& recorder, const Target& target) = 0;

 protected:
  /// As bytes, not as light: the engine's images and the interface's colours are sRGB already.
  static constexpr VkFormat kFormat = VK_FORMAT_B8G8R8A8_UNORM;

  /// \pre shownLayout() may be called
  void makeRenderPass();
  VkFramebuffer makeFramebuffer(VkImageView view) const;

  Gpu& gpu_;
  VkRenderPass render_pass_ = VK_NULL_HANDLE;
  VkExtent2D extent_{};
};

}  // namespace airclay
