// SPDX-License-Identifier: MIT
// A window that shows the images of several cameras beside and below each other, as large as they fit, a
// label below each. What stands over and beside them is its user's.
#pragma once

#include <string>
#include <vector>

#include "app/studio/window.h"
#include "capture/cameras/camera_source.h"
#include "engine/gpu/recorder.h"

namespace airclay {

/// Where a camera's image lies in the window, pixels.
struct ImagePlacement {
  int left = 0, top = 0, width = 0, height = 0;
  double scale = 1;  ///< window's pixels an image's

  int right() const { return left + width; }
  int bottom() const { return top + height; }
};

/// What stands below an image: a name, a word at its right, and a line.
struct CameraLabel {
  std::string name, right, line;
  std::uint32_t line_color = 0;  ///< as in look.h
};

class CameraWindow {
 public:
  CameraWindow(Gpu& gpu, const std::string& title);

  Window& window() { return window_; }

  /// Begins an image: ImGui calls may follow. False while there is nothing to draw on.
  bool begin() { return window_.begin(false) == Window::Begun::kInterface; }
  /// Places images of these sizes, but for `beside_px` at the window's right, in as many columns as let
  /// them be largest, and draws them; grey where one is missing. \pre begin()
  void lay(const std::vector<ImageSize>& sizes, const std::vector<LiveImage>& images, double beside_px = 0);
  const std::vector<ImagePlacement>& places() const { return places_; }
  /// \pre lay()
  void drawLabel(std::size_t camera, const CameraLabel& label) const;
  /// Shows what was begun, and waits for the device.
  void show();

 private:
  void place(const std::vector<ImageSize>& sizes, double width, double height);
  void drawImages(const std::vector<LiveImage>& images);

  Gpu& gpu_;
  Window window_;
  Recorder recorder_;
  Image paper_;  ///< what lies behind the images
  std::vector<ImagePlacement> places_;
  Buffer<std::uint32_t> pixels_;
  std::vector<Inset> insets_;
};

}  // namespace airclay
