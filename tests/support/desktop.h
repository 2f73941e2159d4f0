// SPDX-License-Identifier: MIT
// A private X display with a window manager, simulated keys and mouse, and screenshots.
#pragma once

#include <cstdint>

#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"

namespace airclay {

/// Displayed colours: R G B, rows from the top.
struct Screenshot {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};
/// The fraction of pixels that differ by more than a few levels of 255, within a centred part of the image
/// that is `part` times as wide and high.
double differingFraction(const Screenshot& a, const Screenshot& b, double part);

class Desktop {
 public:
  /// Whether Xvfb, a window manager and xdotool are installed.
  static bool possible();

  struct Options {
    bool shared_memory = true;  ///< the server supports MIT-SHM
  };
  /// Returns when the window manager is running.
  Desktop() : Desktop(Options{}) {}
  explicit Desktop(const Options& options);
  ~Desktop();

  /// Environment variables that open a program's windows on this display.
  std::map<std::string, std::string> environment() const;
  Screenshot screenshot() const;

  // --- xdotool, applied to the only window ---
  /// Waits until the window exists and has the keyboard focus.
  void findWindow(const std::string& title);
  /// In xdotool's syntax: "ctrl+shift+z".
  void key(const std::string& keys);
  void keyDown(const std::string& key);
  void keyUp(const std::string& key);
  void type(const std::string& text);
  /// From the window's upper left corner.
  void moveTo(int x, int y);
  void press(int button = 1);
  void release(int button = 1);
  void resize(int width, int height);
  void minimise();
  void restore();

 private:
  std::string xdotool(const std::vector<std::string>& arguments) const;

  TemporaryFolder folder_;
  std::string display_, window_;
  std::optional<Process> server_, manager_;
};

}  // namespace airclay
