// SPDX-License-Identifier: MIT
// Every key of the studio, once: what handles it and what the help overlay says of it.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace airclay {

struct KeyBinding {
  int key = 0;  ///< GLFW's number
  bool ctrl = false, shift = false;
  std::string shown;           ///< "Ctrl Z"
  std::string does;            ///< "undo"
  std::function<void()> act;   ///< when pressed; none: held keys and the mouse, handled where they belong
  bool repeats = false;        ///< while it is held down
  std::vector<int> held = {};  ///< without `act`: the keys that mean something while they are down
};

struct KeyGroup {
  std::string title;
  std::vector<KeyBinding> bindings;
};

/// Calls what the keys pressed in this image mean. \pre between Window::begin() and present()
void obeyKeys(const std::vector<KeyGroup>& groups);

/// What a key is called on this keyboard: "Space", "F13", "Q".
std::string keyName(int key);
/// The key that went down in this image, of those that name something; 0 when there is none.
int keyPressed();
/// What a key does already, without Ctrl or Shift; none when it is free for the clutch.
std::optional<std::string> meaningOf(const std::vector<KeyGroup>& groups, int key);

/// The overlay with all of them; false once it is closed.
bool drawHelp(const std::vector<KeyGroup>& groups);

}  // namespace airclay
