// SPDX-License-Identifier: MIT
// A window (GLFW) that shows the engine's images with Dear ImGui over them.
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

/// Small images drawn on the window's image, under the interface: B G R A bytes, rows from the top.
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

  /// Whether the environment names a display.
  static bool possible();

  /// All members must be called on the main thread. \throw Error if no window can be opened.
  Window(Gpu& gpu, const Options& options);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  /// Handles events, waiting for up to `wait_s`.
  void poll(double wait_s);
  /// Whether there is unhandled mouse or keyboard input, or a key is down.
  bool inUse() const;
  /// The user asked to close it.
  bool closing() const;
  void close();
  /// Files dropped on the window since the last call.
  std::vector<std::filesystem::path> takeDropped();

  const char* screenName() const;  ///< how images are presented
  int width() const;               ///< pixels; 0 while minimised
  int height() const;              ///< pixels
  /// Size in screen units, for the settings.
  std::pair<int, int> sizeOnScreen() const;

  enum class Begun {
    kNothing,    ///< no image available
    kImage,      ///< an image without a new interface
    kInterface,  ///< an image with an interface: ImGui calls may follow
  };
  /// Begins an image. `interface_may_stay`: images follow quickly, so the interface need not be redrawn in
  /// each.
  Begun begin(bool interface_may_stay);
  /// Draws `frame` (ImageKind::kScreen) over the whole window, then `insets`, then the interface. Submits
  /// `recorder` without waiting. \pre begin() returned an image; the recorder's commands draw `frame`
  void draw(Recorder& recorder, Image& frame, std::span<const Inset> insets);
  /// Shows the image and waits for the device. \pre draw() with this recorder
  void show(Recorder& recorder);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace airclay
