// SPDX-License-Identifier: MIT
// A window with the images of several cameras in a grid, each with a label below it. Callers draw overlays
// and a side panel.
#pragma once

#include <string>
#include <vector>

#include "app/studio/window.h"
#include "capture/cameras/camera_source.h"
#include "engine/gpu/recorder.h"

namespace airclay {

/// A camera's image rectangle in the window, pixels.
struct ImagePlacement {
  int left = 0, top = 0, width = 0, height = 0;
  double scale = 1;  ///< window pixels per image pixel

  int right() const { return left + width; }
  int bottom() const { return top + height; }
};

/// The label below an image: a name, text at its right, and a second line.
struct CameraLabel {
  std::string name, right, line;
  std::uint32_t line_color = 0;  ///< as in theme.h
};

class CameraWindow {
 public:
  CameraWindow(Gpu& gpu, const std::string& title);

  Window& window() { return window_; }

  /// Begins an image; ImGui calls may follow. False while the window has no size.
  bool begin() { return window_.begin(false) == Window::Begun::kInterface; }
  /// Draws images of these sizes as large as possible, leaving `beside_px` free at the window's right;
  /// missing images are grey. \pre begin()
  void lay(const std::vector<ImageSize>& sizes, const std::vector<LiveImage>& images, double beside_px = 0);
  const std::vector<ImagePlacement>& places() const { return places_; }
  /// \pre lay()
  void drawLabel(std::size_t camera, const CameraLabel& label) const;
  /// Shows the image and waits for the device.
  void show();

 private:
  void place(const std::vector<ImageSize>& sizes, double width, double height);
  void drawImages(const std::vector<LiveImage>& images);

  Gpu& gpu_;
  Window window_;
  Recorder recorder_;
  Image paper_;  ///< background of the images
  std::vector<ImagePlacement> places_;
  Buffer<std::uint32_t> pixels_;
  std::vector<Inset> insets_;
};

}  // namespace airclay
