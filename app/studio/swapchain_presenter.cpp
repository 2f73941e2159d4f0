// SPDX-License-Identifier: MIT
#include "app/studio/swapchain_presenter.h"

#include <algorithm>

#include "engine/core/error.h"
#include "engine/gpu/image.h"

namespace airclay {
namespace {

void checkSurface(Gpu& gpu, VkSurfaceKHR surface, VkFormat format) {
  VkBool32 supported = VK_FALSE;
  check(vkGetPhysicalDeviceSurfaceSupportKHR(gpu.physicalDevice(), gpu.queueFamily(), surface, &supported),
        "ask about the display");
  std::uint32_t count = 0;
  if (supported) vkGetPhysicalDeviceSurfaceFormatsKHR(gpu.physicalDevice(), surface, &count, nullptr);
  std::vector<VkSurfaceFormatKHR> formats(count);
  if (supported) vkGetPhysicalDeviceSurfaceFormatsKHR(gpu.physicalDevice(), surface, &count, formats.data());
  const bool has_format = std::any_of(formats.begin(), formats.end(),
                                      [&](const VkSurfaceFormatKHR& f) { return f.format == format; });
  if (!has_format)
    throw Error("the device " + gpu.info().name +
                    " cannot show images on this display; use --headless or another --device",
                Fault::kDevice);
}

}  // namespace

SwapchainPresenter::SwapchainPresenter(Gpu& gpu, VkSurfaceKHR surface) : Presenter(gpu), surface_(surface) {
  checkSurface(gpu, surface, kFormat);
  makeRenderPass();
  ready_ = makeSemaphore();
}

SwapchainPresenter::~SwapchainPresenter() {
  gpu_.waitIdle();
  destroyImages();
  vkDestroySwapchainKHR(gpu_.device(), swapchain_, nullptr);
  vkDestroySemaphore(gpu_.device(), ready_, nullptr);
  vkDestroySurfaceKHR(gpu_.instance(), surface_, nullptr);
}

VkSemaphore SwapchainPresenter::makeSemaphore() {
  const VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
  VkSemaphore semaphore;
  check(vkCreateSemaphore(gpu_.device(), &info, nullptr, &semaphore), "make a semaphore");
  return semaphore;
}

void SwapchainPresenter::destroyImages() {
  for (const Shown& shown : images_) {
    vkDestroyFramebuffer(gpu_.device(), shown.framebuffer, nullptr);
    vkDestroyImageView(gpu_.device(), shown.view, nullptr);
    vkDestroySemaphore(gpu_.device(), shown.drawn, nullptr);
  }
  images_.clear();
}

void SwapchainPresenter::resize(std::uint32_t width, std::uint32_t height) {
  gpu_.waitIdle();
  destroyImages();
  VkSurfaceCapabilitiesKHR can;
  check(vkGetPhysicalDeviceSurfaceCapabilitiesKHR(gpu_.physicalDevice(), surface_, &can),
        "ask about the window");
  extent_ = {std::clamp(width, can.minImageExtent.width, std::max(can.maxImageExtent.width, 1u)),
             std::clamp(height, can.minImageExtent.height, std::max(can.maxImageExtent.height, 1u))};
  VkSwapchainCreateInfoKHR info{VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR};
  info.surface = surface_;
  info.minImageCount = std::max(2u, can.minImageCount);
  if (can.maxImageCount > 0) info.minImageCount = std::min(info.minImageCount, can.maxImageCount);
  info.imageFormat = kFormat;
  info.imageColorSpace = VK_COLOR_SPACE_SRGB_NONLINEAR_KHR;
  info.imageExtent = extent_;
  info.imageArrayLayers = 1;
  info.imageUsage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  if (gpu_.isCpu()) info.imageUsage |= VK_IMAGE_USAGE_TRANSFER_SRC_BIT;  // the interface is copied from them
  info.preTransform = can.currentTransform;
  info.compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR;
  info.presentMode = VK_PRESENT_MODE_FIFO_KHR;
  info.clipped = VK_TRUE;
  info.oldSwapchain = swapchain_;
  VkSwapchainKHR made = VK_NULL_HANDLE;
  check(vkCreateSwapchainKHR(gpu_.device(), &info, nullptr, &made), "make the window's images");
  vkDestroySwapchainKHR(gpu_.device(), swapchain_, nullptr);
  swapchain_ = made;

  std::uint32_t count = 0;
  check(vkGetSwapchainImagesKHR(gpu_.device(), swapchain_, &count, nullptr), "make the window's images");
  std::vector<VkImage> images(count);
  check(vkGetSwapchainImagesKHR(gpu_.device(), swapchain_, &count, images.data()),
        "make the window's images");
  for (VkImage image : images) {
    Shown& shown = images_.emplace_back();
    shown.image = image;
    shown.view = makeImageView(gpu_, image, kFormat, VK_IMAGE_ASPECT_COLOR_BIT);
    shown.framebuffer = makeFramebuffer(shown.view);
    shown.drawn = makeSemaphore();
  }
}

std::optional<Presenter::Target> SwapchainPresenter::acquire() {
  if (images_.empty()) return std::nullopt;
  const VkResult result =
      vkAcquireNextImageKHR(gpu_.device(), swapchain_, UINT64_MAX, ready_, VK_NULL_HANDLE, &acquired_);
  if (result == VK_ERROR_OUT_OF_DATE_KHR) return std::nullopt;
  if (result != VK_SUBOPTIMAL_KHR) check(result, "draw in the window");
  return Target{images_[acquired_].image, images_[acquired_].framebuffer};
}

void SwapchainPresenter::submit(Recorder& recorder, const Target&) {
  VkSemaphoreSubmitInfo ready{VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO};
  ready.semaphore = ready_;
  ready.stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  VkSemaphoreSubmitInfo drawn = ready;
  drawn.semaphore = images_[acquired_].drawn;
  recorder.submit(&ready, &drawn);
}

bool SwapchainPresenter::show(Recorder& recorder, const Target&) {
  const bool fits = present();
  recorder.wait();
  return fits;
}

bool SwapchainPresenter::present() {
  VkPresentInfoKHR info{VK_STRUCTURE_TYPE_PRESENT_INFO_KHR};
  info.waitSemaphoreCount = 1;
  info.pWaitSemaphores = &images_[acquired_].drawn;
  info.swapchainCount = 1;
  info.pSwapchains = &swapchain_;
  info.pImageIndices = &acquired_;
  const std::lock_guard lock(gpu_.queueMutex());
  const VkResult result = vkQueuePresentKHR(gpu_.queue(), &info);
  if (result == VK_ERROR_OUT_OF_DATE_KHR || result == VK_SUBOPTIMAL_KHR) return false;
  check(result, "show the image");
  return true;
}

}  // namespace airclay
