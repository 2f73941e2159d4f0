// SPDX-License-Identifier: MIT
// Presents the images of a software device through memory shared with the X server (MIT-SHM).
//
// Where the server has no DRI3 (Xvfb, VNC), Mesa's swapchain for software devices sends every image through
// the socket; receiving one of 1280 x 720 costs the server 17 ms of processor time, as much as tracking the
// hand costs us.
#pragma once

#include <memory>

#include "app/studio/presenter.h"

struct GLFWwindow;

namespace airclay {

class SharedMemoryPresenter : public Presenter {
 public:
  /// Null if unsupported: on Wayland, on a remote display, or with another channel order.
  static std::unique_ptr<SharedMemoryPresenter> open(Gpu& gpu, GLFWwindow* window);
  ~SharedMemoryPresenter() override;

  const char* name() const override { return "shared memory"; }
  VkImageLayout shownLayout() const override { return VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL; }
  std::uint32_t imageCount() const override { return 1; }
  /// \throw Error (Fault::kDevice) when there is no memory to share.
  void resize(std::uint32_t width, std::uint32_t height) override;
  std::optional<Target> acquire() override;
  void submit(Recorder& recorder, const Target& target) override;
  bool show(Recorder& recorder, const Target& target) override;

 private:
  struct Parts;
  SharedMemoryPresenter(Gpu& gpu, std::unique_ptr<Parts> parts);

  std::unique_ptr<Parts> parts_;
};

}  // namespace airclay
