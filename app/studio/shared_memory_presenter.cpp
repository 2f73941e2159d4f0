// SPDX-License-Identifier: MIT
#include "app/studio/shared_memory_presenter.h"

#include <cstring>

#include "engine/core/error.h"
#include "engine/gpu/image.h"

// X11's headers come last: they define common words as macros.
#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <X11/extensions/XShm.h>
#include <sys/ipc.h>
#include <sys/shm.h>

// Declared as in glfw3native.h, which needs more X11 headers. GLFW's Wayland build lacks these functions.
extern "C" {
__attribute__((weak)) Display* glfwGetX11Display();
__attribute__((weak)) ::Window glfwGetX11Window(GLFWwindow* window);
}

namespace airclay {
namespace {

/// Catches X server errors, which would otherwise end the program.
class XFaults {
 public:
  explicit XFaults(Display* display) : display_(display), before_(XSetErrorHandler(note)) { seen_ = false; }
  ~XFaults() {
    XSync(display_, False);
    XSetErrorHandler(before_);
  }
  bool any() {
    XSync(display_, False);
    return seen_;
  }

 private:
  static int note(Display*, XErrorEvent*) {
    seen_ = true;
    return 0;
  }
  static inline bool seen_ = false;
  Display* display_;
  XErrorHandler before_;
};

/// An image in memory shared with the X server; freed when both have released it.
class SharedImage {
 public:
  /// Check valid() afterwards.
  SharedImage(Display* display, const XWindowAttributes& window, std::uint32_t width, std::uint32_t height)
      : display_(display) {
    image_ = XShmCreateImage(display, window.visual, static_cast<unsigned>(window.depth), ZPixmap, nullptr,
                             &segment_, width, height);
    if (!image_) return;
    const auto bytes = static_cast<std::size_t>(image_->bytes_per_line) * height;
    segment_.shmid = shmget(IPC_PRIVATE, bytes, IPC_CREAT | 0600);
    if (segment_.shmid < 0) return;
    void* const memory = shmat(segment_.shmid, nullptr, 0);
    if (memory != reinterpret_cast<void*>(-1)) {
      segment_.shmaddr = image_->data = static_cast<char*>(memory);
      XFaults faults(display);
      attached_ = XShmAttach(display, &segment_) && !faults.any();
    }
    shmctl(segment_.shmid, IPC_RMID, nullptr);  // freed with its last user, even after a crash
  }
  ~SharedImage() {
    if (attached_) {
      XShmDetach(display_, &segment_);
      XSync(display_, False);
    }
    if (segment_.shmaddr) shmdt(segment_.shmaddr);
    if (!image_) return;
    image_->data = nullptr;  // not owned by Xlib
    XDestroyImage(image_);
  }
  SharedImage(const SharedImage&) = delete;
  SharedImage& operator=(const SharedImage&) = delete;

  bool valid() const { return attached_; }
  /// Whether its pixel format is VK_FORMAT_B8G8R8A8.
  bool isBgra() const {
    return image_->bits_per_pixel == 32 && image_->byte_order == LSBFirst && image_->red_mask == 0xFF0000 &&
           image_->green_mask == 0xFF00 && image_->blue_mask == 0xFF;
  }
  void fill(std::span<const std::uint32_t> pixels) {
    const auto width = static_cast<std::size_t>(image_->width);
    for (std::size_t y = 0; y < static_cast<std::size_t>(image_->height); ++y)
      std::memcpy(image_->data + y * static_cast<std::size_t>(image_->bytes_per_line),
                  pixels.data() + y * width, 4 * width);
  }
  /// Returns when the server has read it.
  void show(::Window window, GC context) {
    XShmPutImage(display_, window, context, image_, 0, 0, 0, 0, static_cast<unsigned>(image_->width),
                 static_cast<unsigned>(image_->height), False);
    XSync(display_, False);
  }

 private:
  Display* display_;
  XShmSegmentInfo segment_{};
  XImage* image_ = nullptr;
  bool attached_ = false;
};

}  // namespace

struct SharedMemoryPresenter::Parts {
  explicit Parts(Display* display_, ::Window window_) : display(display_), window(window_) {
    XGetWindowAttributes(display, window, &attributes);
    context = XCreateGC(display, window, 0, nullptr);
  }
  ~Parts() { XFreeGC(display, context); }

  Display* display;
  ::Window window;
  XWindowAttributes attributes{};
  GC context;
  std::optional<SharedImage> shared;
  Image drawn;
  Buffer<std::uint32_t> pixels;
  VkImageView view = VK_NULL_HANDLE;
  VkFramebuffer framebuffer = VK_NULL_HANDLE;

  void destroyView(VkDevice device) {
    vkDestroyFramebuffer(device, framebuffer, nullptr);
    vkDestroyImageView(device, view, nullptr);
    framebuffer = VK_NULL_HANDLE;
    view = VK_NULL_HANDLE;
  }
};

std::unique_ptr<SharedMemoryPresenter> SharedMemoryPresenter::open(Gpu& gpu, GLFWwindow* window) {
  Display* const display = &glfwGetX11Display ? glfwGetX11Display() : nullptr;
  if (!display || !XShmQueryExtension(display)) return nullptr;
  auto parts = std::make_unique<Parts>(display, glfwGetX11Window(window));
  const SharedImage trial(display, parts->attributes, 1, 1);
  if (!trial.valid() || !trial.isBgra()) return nullptr;
  return std::unique_ptr<SharedMemoryPresenter>(new SharedMemoryPresenter(gpu, std::move(parts)));
}

SharedMemoryPresenter::SharedMemoryPresenter(Gpu& gpu, std::unique_ptr<Parts> parts)
    : Presenter(gpu), parts_(std::move(parts)) {
  makeRenderPass();
}

SharedMemoryPresenter::~SharedMemoryPresenter() {
  gpu_.waitIdle();
  parts_->destroyView(gpu_.device());
}

void SharedMemoryPresenter::resize(std::uint32_t width, std::uint32_t height) {
  gpu_.waitIdle();
  parts_->destroyView(gpu_.device());
  extent_ = {width, height};
  parts_->shared.reset();
  parts_->shared.emplace(parts_->display, parts_->attributes, width, height);
  if (!parts_->shared->valid()) {
    parts_->shared.reset();
    throw Error("there is no memory to share with the display for a window of " + std::to_string(width) +
                    " x " + std::to_string(height) + " pixels",
                Fault::kDevice);
  }
  parts_->drawn = Image(gpu_, ImageKind::kScreen, width, height);
  parts_->pixels = Buffer<std::uint32_t>(gpu_, std::size_t(width) * height, Memory::kHost);
  parts_->view = makeImageView(gpu_, parts_->drawn.handle(), kFormat, VK_IMAGE_ASPECT_COLOR_BIT);
  parts_->framebuffer = makeFramebuffer(parts_->view);
}

std::optional<Presenter::Target> SharedMemoryPresenter::acquire() {
  if (!parts_->shared) return std::nullopt;
  return Target{parts_->drawn.handle(), parts_->framebuffer};
}

void SharedMemoryPresenter::submit(Recorder& recorder, const Target& target) {
  const RawBuffer& pixels = parts_->pixels.raw();
  VkCommandBuffer commands = recorder.commandsFor("copy image", {{pixels.address(), false, true}});
  recordLayout(commands, target.image, VK_IMAGE_ASPECT_COLOR_BIT, shownLayout(), shownLayout());
  VkBufferImageCopy region{};
  region.bufferOffset = pixels.offset();
  region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  region.imageExtent = {extent_.width, extent_.height, 1};
  vkCmdCopyImageToBuffer(commands, target.image, shownLayout(), pixels.handle(), 1, &region);
  recorder.submit();
}

bool SharedMemoryPresenter::show(Recorder& recorder, const Target&) {
  recorder.wait();
  parts_->shared->fill(parts_->pixels.host());
  parts_->shared->show(parts_->window, parts_->context);
  return true;
}

}  // namespace airclay
