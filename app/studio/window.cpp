// SPDX-License-Identifier: MIT
#include "app/studio/window.h"

// GLFW declares its Vulkan functions when it sees Vulkan's header, which gpu.h has included.
#include <GLFW/glfw3.h>
#include <imgui/backends/imgui_impl_glfw.h>
#include <imgui/backends/imgui_impl_vulkan.h>
#include <imgui/imgui.h>

#include <chrono>
#include <cstdlib>
#include <set>

#include "app/studio/shared_memory_presenter.h"
#include "app/studio/swapchain_presenter.h"
#include "app/studio/theme.h"
#include "engine/core/error.h"
#include "engine/gpu/one_time.h"

namespace airclay {
namespace {

/// Longest time between interface updates; faster changes of numbers are not readable.
constexpr auto kInterfaceStays = std::chrono::milliseconds(100);

std::string last_glfw_fault;

void glfwFault(int, const char* text) {
  last_glfw_fault = text;
}

[[noreturn]] void refuseToOpen() {
  throw Error("no window can be opened (" + last_glfw_fault + "); --headless works without a display",
              Fault::kDevice);
}

/// Initializes GLFW while a window exists.
struct Glfw {
  Glfw() {
    glfwSetErrorCallback(glfwFault);
    if (!glfwInit()) refuseToOpen();
  }
  ~Glfw() { glfwTerminate(); }
};

VkDescriptorPool makeDescriptorPool(Gpu& gpu) {
  // Dear ImGui's only texture is the font atlas
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1};
  VkDescriptorPoolCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  info.maxSets = 1;
  info.poolSizeCount = 1;
  info.pPoolSizes = &size;
  VkDescriptorPool pool;
  check(vkCreateDescriptorPool(gpu.device(), &info, nullptr, &pool), "make a descriptor pool");
  return pool;
}

/// Queues keyboard events for the following images. Dear ImGui 1.86 samples the keys once per image and would
/// miss one that was pressed and released in between.
class KeyEvents {
 public:
  void add(int key, int scancode, int action, int modifiers) {
    if (action != GLFW_REPEAT) waiting_.push_back({key, scancode, action, modifiers});
  }
  bool waiting() const { return !waiting_.empty(); }

  /// Delivers the events of one image: at most one change per key, and none across a change of Ctrl, Shift,
  /// Alt or Super.
  void handOn(GLFWwindow* window) {
    std::vector<Event> later;
    std::set<int> changed;
    for (auto event = waiting_.begin(); event != waiting_.end(); ++event) {
      const bool modifier = event->key >= GLFW_KEY_LEFT_SHIFT && event->key <= GLFW_KEY_RIGHT_SUPER;
      if (modifier && !changed.empty()) {
        later.insert(later.end(), event, waiting_.end());
        break;
      }
      if (!modifier && !changed.insert(event->key).second)
        later.push_back(*event);
      else
        ImGui_ImplGlfw_KeyCallback(window, event->key, event->scancode, event->action, event->modifiers);
    }
    waiting_ = std::move(later);
  }

 private:
  struct Event {
    int key = 0, scancode = 0, action = 0, modifiers = 0;
  };
  std::vector<Event> waiting_;
};

void transition(VkCommandBuffer commands, VkImage image, VkImageLayout from, VkImageLayout to) {
  recordLayout(commands, image, VK_IMAGE_ASPECT_COLOR_BIT, from, to);
}

/// Right after a resize, the image still has the previous size.
void fillWith(VkCommandBuffer commands, Image& frame, VkImage image, VkExtent2D extent) {
  frame.transition(commands, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, true);
  VkImageCopy region{};
  region.srcSubresource = region.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  region.extent = {std::min(frame.width(), extent.width), std::min(frame.height(), extent.height), 1};
  vkCmdCopyImage(commands, frame.handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, image,
                 VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
}

void lay(VkCommandBuffer commands, const Inset& inset, VkImage image, VkExtent2D extent) {
  const int width = std::min(inset.width, static_cast<int>(extent.width) - inset.left);
  const int height = std::min(inset.height, static_cast<int>(extent.height) - inset.top);
  if (inset.left < 0 || inset.top < 0 || width <= 0 || height <= 0) return;
  VkBufferImageCopy region{};
  region.bufferOffset = inset.pixels->raw().offset() + 4 * inset.first;
  region.bufferRowLength = static_cast<std::uint32_t>(inset.width);
  region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  region.imageOffset = {inset.left, inset.top, 0};
  region.imageExtent = {static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), 1};
  vkCmdCopyBufferToImage(commands, inset.pixels->raw().handle(), image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                         1, &region);
}

/// The area of the interface: one rectangle per window and inset.
std::vector<VkRect2D> coveredBy(const ImDrawData& interface, std::span<const Inset> insets,
                                VkExtent2D extent) {
  std::vector<VkRect2D> covered;
  const auto add = [&](float left, float top, float right, float bottom) {
    const auto within = [](float value, std::uint32_t most) {
      return static_cast<int>(std::clamp(value, 0.0f, static_cast<float>(most)));
    };
    const int x = within(std::floor(left), extent.width), y = within(std::floor(top), extent.height);
    const int width = within(std::ceil(right), extent.width) - x,
              height = within(std::ceil(bottom), extent.height) - y;
    if (width <= 0 || height <= 0) return;
    covered.push_back({{x, y}, {static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)}});
  };
  for (const Inset& inset : insets)
    add(static_cast<float>(inset.left), static_cast<float>(inset.top),
        static_cast<float>(inset.left + inset.width), static_cast<float>(inset.top + inset.height));
  for (int i = 0; i < interface.CmdListsCount; ++i) {
    const ImVector<ImDrawVert>& vertices = interface.CmdLists[i]->VtxBuffer;
    if (vertices.empty()) continue;
    ImVec2 low = vertices[0].pos, high = low;
    for (const ImDrawVert& vertex : vertices) {
      low = {std::min(low.x, vertex.pos.x), std::min(low.y, vertex.pos.y)};
      high = {std::max(high.x, vertex.pos.x), std::max(high.y, vertex.pos.y)};
    }
    add(low.x, low.y, high.x, high.y);
  }
  return covered;
}

/// Copies rectangles to the same place in the other image.
void copyParts(VkCommandBuffer commands, VkImage from, VkImage to, std::span<const VkRect2D> parts) {
  std::vector<VkImageCopy> regions;
  for (const VkRect2D& part : parts) {
    VkImageCopy region{};
    region.srcSubresource = region.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.srcOffset = region.dstOffset = {part.offset.x, part.offset.y, 0};
    region.extent = {part.extent.width, part.extent.height, 1};
    regions.push_back(region);
  }
  if (regions.empty()) return;
  vkCmdCopyImage(commands, from, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to,
                 VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, static_cast<std::uint32_t>(regions.size()),
                 regions.data());
}

}  // namespace

struct Window::Parts {
  explicit Parts(Gpu& device) : gpu(device) {}
  ~Parts() {
    if (screen) gpu.waitIdle();
    if (toolkit_on_device) ImGui_ImplVulkan_Shutdown();
    if (toolkit_on_window) ImGui_ImplGlfw_Shutdown();
    if (context) ImGui::DestroyContext(context);
    screen.reset();
    if (descriptors) vkDestroyDescriptorPool(gpu.device(), descriptors, nullptr);
    if (window) glfwDestroyWindow(window);
  }

  Gpu& gpu;
  Glfw glfw;
  GLFWwindow* window = nullptr;
  std::unique_ptr<Presenter> screen;
  VkDescriptorPool descriptors = VK_NULL_HANDLE;
  ImGuiContext* context = nullptr;
  bool toolkit_on_window = false, toolkit_on_device = false;
  std::optional<Presenter::Target> target;
  bool changed = true;  ///< the window's size has changed
  std::vector<std::filesystem::path> dropped;
  KeyEvents keys;
  double scale = 1;
  Image kept;  ///< the interface as last drawn; its corners show that image
  std::vector<VkRect2D> kept_parts;
  bool draws_interface = true;  ///< in this image
  bool used = true;             ///< mouse or keyboard input since the interface was last drawn
  int held = 0;                 ///< keys and buttons that are down
  std::chrono::steady_clock::time_point interface_at{};

  void drawInterface(VkCommandBuffer commands, std::span<const Inset> insets);
  void keepInterface(VkCommandBuffer commands, std::span<const Inset> insets);
  void layInterface(VkCommandBuffer commands);

  VkExtent2D pixels() const {
    int width = 0, height = 0;
    glfwGetFramebufferSize(window, &width, &height);
    if (glfwGetWindowAttrib(window, GLFW_ICONIFIED)) width = height = 0;
    return {static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)};
  }

  void open(const Options& options) {
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    window = glfwCreateWindow(options.width, options.height, options.title.c_str(), nullptr, nullptr);
    if (!window) refuseToOpen();
    glfwSetWindowSizeLimits(window, 640, 400, GLFW_DONT_CARE, GLFW_DONT_CARE);
    glfwSetWindowUserPointer(window, this);
    glfwSetFramebufferSizeCallback(window, [](GLFWwindow* w, int, int) { of(w).changed = true; });
    glfwSetDropCallback(window, [](GLFWwindow* w, int count, const char** paths) {
      auto& files = of(w).dropped;
      files.insert(files.end(), paths, paths + count);
    });
    float horizontal = 1, vertical = 1;
    glfwGetWindowContentScale(window, &horizontal, &vertical);
    scale = std::clamp(double(horizontal), 1.0, 4.0);
    if (gpu.isCpu()) screen = SharedMemoryPresenter::open(gpu, window);
    if (!screen) {
      VkSurfaceKHR surface;
      check(glfwCreateWindowSurface(gpu.instance(), window, nullptr, &surface), "open the window for Vulkan");
      screen = std::make_unique<SwapchainPresenter>(gpu, surface);
    }
    fit();
    startToolkit();
  }

  void fit() {
    const VkExtent2D size = pixels();
    if (size.width == 0 || size.height == 0) return;
    screen->resize(size.width, size.height);
    kept = {};
    changed = false;
  }

  static Parts& of(GLFWwindow* window) { return *static_cast<Parts*>(glfwGetWindowUserPointer(window)); }
  void use(int action) {
    used = true;
    held = std::max(0, held + (action == GLFW_PRESS) - (action == GLFW_RELEASE));
  }
  /// Dear ImGui's own callbacks call these. \pre before it starts
  void watchInput() {
    glfwSetCursorPosCallback(window, [](GLFWwindow* w, double, double) { of(w).used = true; });
    glfwSetScrollCallback(window, [](GLFWwindow* w, double, double) { of(w).used = true; });
    glfwSetCharCallback(window, [](GLFWwindow* w, unsigned) { of(w).used = true; });
    glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int, int action, int) { of(w).use(action); });
  }
  bool inUse() const { return used || held > 0 || keys.waiting(); }
  bool interfaceStays() const {
    return gpu.isCpu() && kept.handle() && !inUse() &&
           std::chrono::steady_clock::now() - interface_at < kInterfaceStays;
  }

  void startToolkit() {
    watchInput();
    context = ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;  // the studio stores its own settings
    applyTheme(scale);
    toolkit_on_window = ImGui_ImplGlfw_InitForVulkan(window, true);
    glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int scancode, int action, int modifiers) {
      of(w).use(action);
      of(w).keys.add(key, scancode, action, modifiers);
    });
    descriptors = makeDescriptorPool(gpu);
    ImGui_ImplVulkan_InitInfo info{};
    info.Instance = gpu.instance();
    info.PhysicalDevice = gpu.physicalDevice();
    info.Device = gpu.device();
    info.QueueFamily = gpu.queueFamily();
    info.Queue = gpu.queue();
    info.DescriptorPool = descriptors;
    info.MinImageCount = 2;
    info.ImageCount = std::max(2u, screen->imageCount());
    info.MSAASamples = VK_SAMPLE_COUNT_1_BIT;
    info.CheckVkResultFn = [](VkResult result) { check(result, "draw the interface"); };
    toolkit_on_device = ImGui_ImplVulkan_Init(&info, screen->renderPass());
    submitOnce(gpu, [](VkCommandBuffer commands) { ImGui_ImplVulkan_CreateFontsTexture(commands); });
    ImGui_ImplVulkan_DestroyFontUploadObjects();
  }
};

bool Window::possible() {
  const char* x = std::getenv("DISPLAY");
  const char* wayland = std::getenv("WAYLAND_DISPLAY");
  return (x && *x) || (wayland && *wayland);
}

Window::Window(Gpu& gpu, const Options& options) : parts_(std::make_unique<Parts>(gpu)) {
  parts_->open(options);
}
Window::~Window() = default;

void Window::poll(double wait_s) {
  if (wait_s > 0 && !parts_->keys.waiting())
    glfwWaitEventsTimeout(wait_s);
  else
    glfwPollEvents();
}

bool Window::inUse() const {
  return parts_->inUse();
}

bool Window::closing() const {
  return glfwWindowShouldClose(parts_->window);
}
void Window::close() {
  glfwSetWindowShouldClose(parts_->window, GLFW_TRUE);
}

std::vector<std::filesystem::path> Window::takeDropped() {
  return std::exchange(parts_->dropped, {});
}

const char* Window::screenName() const {
  return parts_->screen->name();
}
int Window::width() const {
  return static_cast<int>(parts_->pixels().width);
}
int Window::height() const {
  return static_cast<int>(parts_->pixels().height);
}
std::pair<int, int> Window::sizeOnScreen() const {
  int width = 0, height = 0;
  glfwGetWindowSize(parts_->window, &width, &height);
  return {width, height};
}

Window::Begun Window::begin(bool interface_may_stay) {
  const VkExtent2D size = parts_->pixels();
  if (size.width == 0 || size.height == 0) return Begun::kNothing;
  if (parts_->changed) parts_->fit();
  parts_->target = parts_->screen->acquire();
  if (!parts_->target) {
    parts_->fit();
    parts_->target = parts_->screen->acquire();
    if (!parts_->target) return Begun::kNothing;  // it is being resized: skip this image
  }
  parts_->draws_interface = !interface_may_stay || !parts_->interfaceStays();
  if (!parts_->draws_interface) return Begun::kImage;
  parts_->used = false;
  parts_->interface_at = std::chrono::steady_clock::now();
  parts_->keys.handOn(parts_->window);
  ImGui_ImplVulkan_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
  return Begun::kInterface;
}

/// Draws the interface over the window's image. \post the image can be shown
void Window::Parts::drawInterface(VkCommandBuffer commands, std::span<const Inset> insets) {
  const VkExtent2D extent = screen->extent();
  if (!insets.empty())
    transition(commands, target->image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
               VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
  for (const Inset& inset : insets) lay(commands, inset, target->image, extent);
  transition(commands, target->image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
             VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
  VkRenderPassBeginInfo pass{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
  pass.renderPass = screen->renderPass();
  pass.framebuffer = target->framebuffer;
  pass.renderArea.extent = extent;
  vkCmdBeginRenderPass(commands, &pass, VK_SUBPASS_CONTENTS_INLINE);
  ImGui_ImplVulkan_RenderDrawData(ImGui::GetDrawData(), commands);
  vkCmdEndRenderPass(commands);
}

/// Saves the interface that was just drawn.
void Window::Parts::keepInterface(VkCommandBuffer commands, std::span<const Inset> insets) {
  const VkExtent2D extent = screen->extent();
  if (!kept.handle()) kept = Image(gpu, ImageKind::kScreen, extent.width, extent.height);
  kept_parts = coveredBy(*ImGui::GetDrawData(), insets, extent);
  kept.transition(commands, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, false);
  transition(commands, target->image, screen->shownLayout(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  copyParts(commands, target->image, kept.handle(), kept_parts);
  transition(commands, target->image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, screen->shownLayout());
}

/// Draws the saved interface over the window's image. \post the image can be shown
void Window::Parts::layInterface(VkCommandBuffer commands) {
  kept.transition(commands, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, true);
  transition(commands, target->image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
             VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
  copyParts(commands, kept.handle(), target->image, kept_parts);
  transition(commands, target->image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, screen->shownLayout());
}

void Window::draw(Recorder& recorder, Image& frame, std::span<const Inset> insets) {
  const Presenter::Target target = *parts_->target;
  std::vector<Access> accesses;
  for (const Inset& inset : insets) accesses.push_back({inset.pixels->raw().address(), true, false});
  recorder.stage("image: window");
  VkCommandBuffer commands = recorder.commandsFor("window", accesses);
  transition(commands, target.image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
  fillWith(commands, frame, target.image, parts_->screen->extent());
  if (parts_->draws_interface) {
    ImGui::Render();
    parts_->drawInterface(commands, insets);
    if (parts_->gpu.isCpu()) parts_->keepInterface(commands, insets);
  } else {
    parts_->layInterface(commands);
  }

  parts_->screen->submit(recorder, target);
}

void Window::show(Recorder& recorder) {
  if (!parts_->screen->show(recorder, *parts_->target)) parts_->changed = true;
}

}  // namespace airclay
