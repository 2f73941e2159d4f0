// SPDX-License-Identifier: MIT
// What the sculptor is told anew in each frame.
#pragma once

#include "engine/sculpt/symmetry.h"

namespace airclay {

enum class Tool {
  kPush,    ///< the paper's: the clay gives way to the hand (engine/sculpt/contact.h)
  kPull,    ///< touched clay sticks to the hand and follows it (engine/sculpt/grip.h)
  kSmooth,  ///< clay near the hand relaxes (engine/sculpt/relax.h)
};

/// As histories call its strokes.
inline const char* toolName(Tool tool) {
  return tool == Tool::kPush ? "Push" : tool == Tool::kPull ? "Pull" : "Smooth";
}

struct SculptControls {
  Tool tool = Tool::kPush;
  Symmetry symmetry = {};
  bool held = true;             ///< the clutch: false leaves the clay alone
  double frame_s = 1.0 / 30.0;  ///< since the last frame, by the images' own clock: how far smoothing goes
};

}  // namespace airclay
