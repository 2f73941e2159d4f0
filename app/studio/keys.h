// SPDX-License-Identifier: MIT
// Every key of the studio, once: what handles it and what the help overlay says of it.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace airclay {

struct KeyBinding {
  int key = 0;  ///< GLFW's number
  bool ctrl = false, shift = false;
  std::string shown;          ///< "Ctrl Z"
  std::string does;           ///< "undo"
  std::function<void()> act;  ///< when pressed; none: held keys and the mouse, handled where they belong
  bool repeats = false;       ///< while it is held down
};

struct KeyGroup {
  std::string title;
  std::vector<KeyBinding> bindings;
};

/// Calls what the keys pressed in this picture mean. \pre between Window::begin() and present()
void obeyKeys(const std::vector<KeyGroup>& groups);

/// The overlay with all of them; false once it is closed.
bool drawHelp(const std::vector<KeyGroup>& groups);

}  // namespace airclay
