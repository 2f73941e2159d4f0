// SPDX-License-Identifier: MIT
// The images that a window shows in turn.
#pragma once

#include <optional>
#include <vector>

#include "engine/gpu/gpu.h"

namespace airclay {

/// Owns the surface's images, their framebuffers for Dear ImGui, and what tells when each may be drawn and
/// shown.
class Swapchain {
 public:
  /// Takes the surface over. \throw Error (Fault::kDevice) when the device cannot show pictures on it.
  Swapchain(Gpu& gpu, VkSurfaceKHR surface);
  ~Swapchain();
  Swapchain(const Swapchain&) = delete;
  Swapchain& operator=(const Swapchain&) = delete;

  VkRenderPass renderPass() const { return render_pass_; }
  std::uint32_t imageCount() const { return static_cast<std::uint32_t>(images_.size()); }
  VkExtent2D extent() const { return extent_; }

  /// The window has another size, in pixels. Waits for what is being drawn.
  void resize(std::uint32_t width, std::uint32_t height);

  struct Target {
    std::uint32_t index = 0;
    VkImage image = VK_NULL_HANDLE;
    VkFramebuffer framebuffer = VK_NULL_HANDLE;
    VkSemaphore ready = VK_NULL_HANDLE;  ///< signalled when the image may be drawn into
    VkSemaphore drawn = VK_NULL_HANDLE;  ///< to be signalled when it has been
  };
  /// The next image; none when the window has changed: resize(), and ask again. \pre the last picture's
  /// submission is done
  std::optional<Target> acquire();
  /// False when the window has changed.
  bool show(const Target& target);

 private:
  struct Shown {
    VkImage image = VK_NULL_HANDLE;
    VkImageView view = VK_NULL_HANDLE;
    VkFramebuffer framebuffer = VK_NULL_HANDLE;
    VkSemaphore drawn = VK_NULL_HANDLE;
  };
  void makeRenderPass();
  void destroyImages();
  VkSemaphore makeSemaphore();

  Gpu& gpu_;
  VkSurfaceKHR surface_;
  VkSwapchainKHR swapchain_ = VK_NULL_HANDLE;
  VkRenderPass render_pass_ = VK_NULL_HANDLE;
  VkSemaphore ready_ = VK_NULL_HANDLE;
  VkExtent2D extent_{};
  std::vector<Shown> images_;
};

}  // namespace airclay
