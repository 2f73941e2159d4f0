// SPDX-License-Identifier: MIT
// A display of a test's own, with a window manager, and what somebody sitting before it would do.
#pragma once

#include <cstdint>

#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"

namespace airclay {

/// Colours as they stand on the display: R G B, rows from the top.
struct Screenshot {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};
/// How much of the image differs by more than a few of 255 levels, of 1, within a part of it that is
/// centred and `part` times as wide and high.
double differingShare(const Screenshot& a, const Screenshot& b, double part);

class Desktop {
 public:
  /// Whether there is an X server that needs no screen.
  static bool possible();

  struct Options {
    bool shared_memory = true;  ///< the server takes images from memory that it shares with programs
  };
  /// Ready when this returns: the window manager has taken over.
  Desktop() : Desktop(Options{}) {}
  explicit Desktop(const Options& options);
  ~Desktop();

  /// What a program must have in its environment to come up here.
  std::map<std::string, std::string> environment() const;
  Screenshot screenshot() const;

  // --- as xdotool does it, to the window that is the only one ---
  /// Waits for it, and for it to have the keyboard.
  void findWindow(const std::string& title);
  /// As xdotool names them: "ctrl+shift+z".
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
  std::string xdotool(const std::vector<std::string>& words) const;

  TemporaryFolder folder_;
  std::string display_, window_;
  std::optional<Process> server_, manager_;
};

}  // namespace airclay
