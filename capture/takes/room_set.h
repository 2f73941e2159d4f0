// SPDX-License-Identifier: MIT
// The standard set of rendered recordings with which `airclay evaluate --synthetic` measures tracking.
#pragma once

#include <string>
#include <vector>

#include "engine/synthetic/room_options.h"

namespace airclay {

struct RoomTake {
  std::string name;
  std::string contents;  ///< what it varies, for the help text
  RoomOptions options;
};

/// Each recording varies one condition of a hand over a cloth without noise ("clean"), or of a desk with
/// everything a room has; each has its own seed, so its own path and colours, and its own rotation of the
/// world.
std::vector<RoomTake> standardRooms();

}  // namespace airclay
