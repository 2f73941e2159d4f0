// SPDX-License-Identifier: MIT
// A window on the display (GLFW) that shows the engine's images, with Dear ImGui over them.
//
// The image is drawn offscreen by engine/render/renderer.h and copied into the window's image (screen.h);
// Dear ImGui 1.86 draws over it in the one VkRenderPass that there is. On a software device that costs as
// much as tracking a quarter of a frame, so between images that follow each other quickly the interface is
// kept, unless it is in use.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/gpu/image.h"

namespace airclay {

/// Small images that lie on the window's image, under the interface: B G R A bytes, rows from the top.
struct Inset {
  const Buffer<std::uint32_t>* pixels = nullptr;
  std::size_t first = 0;      ///< of `pixels`
  int width = 0, height = 0;  ///< pixels
  int left = 0, top = 0;      ///< in the window, pixels
};

class Window {
 public:
  struct Options {
    std::string title = "Airclay";
    int width = 1280, height = 800;  ///< screen units
  };

  /// Whether there is a display that a window could open on, as the environment says.
  static bool possible();

  /// On the main thread, as everything here. \throw Error when no window can be opened.
  Window(Gpu& gpu, const Options& options);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  /// Handles what has happened, waiting for it for up to `wait_s`.
  void poll(double wait_s);
  /// Whether the mouse or the keyboard has done something that no interface has seen yet, or a key is down.
  bool inUse() const;
  /// The user wants it closed.
  bool closing() const;
  void close();
  /// Files dropped on the window since the last call.
  std::vector<std::filesystem::path> takeDropped();

  const char* screenName() const;  ///< how images come to the display
  int width() const;               ///< pixels; 0 while minimised
  int height() const;              ///< pixels
  /// In screen units, to be remembered.
  std::pair<int, int> sizeOnScreen() const;

  enum class Begun {
    kNothing,    ///< there is nothing to draw on
    kImage,      ///< the interface stays as it is
    kInterface,  ///< an image with its interface: ImGui calls may follow
  };
  /// Begins an image. `interface_may_stay`: one follows the other quickly, and it need not be drawn in each.
  Begun begin(bool interface_may_stay);
  /// Ends it: `image` (ImageKind::kScreen) fills the window, `insets` lie on it, the interface over all.
  /// Submits what `recorder` has, and returns without waiting for it. \pre begin() gave something; the
  /// recorder's commands draw `image`
  void draw(Recorder& recorder, Image& frame, std::span<const Inset> insets);
  /// Shows what was drawn, and waits for the device. \pre draw() with this recorder
  void show(Recorder& recorder);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace airclay
