// SPDX-License-Identifier: MIT
// The swapchain of a window.
#pragma once

#include <vector>

#include "app/studio/presenter.h"

namespace airclay {

/// Owns the surface's images, their framebuffers and semaphores.
class SwapchainPresenter : public Presenter {
 public:
  /// Takes ownership of the surface. \throw Error (Fault::kDevice) if the device cannot show images on it.
  SwapchainPresenter(Gpu& gpu, VkSurfaceKHR surface);
  ~SwapchainPresenter() override;

  const char* name() const override { return "swapchain"; }
  VkImageLayout shownLayout() const override { return VK_IMAGE_LAYOUT_PRESENT_SRC_KHR; }
  std::uint32_t imageCount() const override { return static_cast<std::uint32_t>(images_.size()); }
  void resize(std::uint32_t width, std::uint32_t height) override;
  std::optional<Target> acquire() override;
  void submit(Recorder& recorder, const Target& target) override;
  bool show(Recorder& recorder, const Target& target) override;

 private:
  struct Shown {
    VkImage image = VK_NULL_HANDLE;
    VkImageView view = VK_NULL_HANDLE;
    VkFramebuffer framebuffer = VK_NULL_HANDLE;
    VkSemaphore drawn = VK_NULL_HANDLE;  ///< signalled when it is drawn
  };
  void destroyImages();
  bool present();
  VkSemaphore makeSemaphore();

  VkSurfaceKHR surface_;
  VkSwapchainKHR swapchain_ = VK_NULL_HANDLE;
  VkSemaphore ready_ = VK_NULL_HANDLE;  ///< signalled when the acquired image may be drawn into
  std::vector<Shown> images_;
  std::uint32_t acquired_ = 0;  ///< of images_, since the last acquire()
};

}  // namespace airclay
