// SPDX-License-Identifier: MIT
// All key bindings of the studio: their actions and their descriptions in the help overlay.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace airclay {

struct KeyBinding {
  int key = 0;  ///< GLFW code
  bool ctrl = false, shift = false;
  std::string shown;           ///< "Ctrl Z"
  std::string does;            ///< "Undo"
  std::function<void()> act;   ///< called on a key press; empty: handled elsewhere (held keys, mouse)
  bool repeats = false;        ///< repeat while the key is down
  std::vector<int> held = {};  ///< without `act`: the keys that act while they are down
};

struct KeyGroup {
  std::string title;
  std::vector<KeyBinding> bindings;
};

/// Runs the actions of the keys pressed in this image. \pre between Window::begin() and present()
void obeyKeys(const std::vector<KeyGroup>& groups);

/// The name of a key on this keyboard: "Space", "F13", "Q".
std::string keyName(int key);
/// The key pressed in this image; 0 if none.
int keyPressed();
/// What a key does without Ctrl or Shift; nullopt if it is free for the clutch.
std::optional<std::string> meaningOf(const std::vector<KeyGroup>& groups, int key);

/// Draws the help overlay; false once it is closed.
bool drawHelp(const std::vector<KeyGroup>& groups);

}  // namespace airclay
