// SPDX-License-Identifier: MIT
// The path of a hand over a desk: enters the cube, reaches, turns about all axes, rests, reaches, and leaves.
#pragma once

#include <cstdint>

#include "engine/synthetic/script.h"

namespace airclay {

struct RoomPath {
  std::uint32_t seed = 1;
  double begins_s = 0;  ///< when the hand starts to move, from its place of rest outside the cube
  double ends_s = 3;    ///< when it is back there
  double peak_speed_m_s =
      0.6;  ///< of the wrist between places in the cube; it enters and leaves at up to 1 m/s
  double still_s = 1;
};

/// room_from_wrist of a right hand: x along the fingers, z out of the back of the hand, origin at the wrist.
/// From the beginning of time the hand is at its place of rest.
HandScript roomScript(const RoomPath& path);

}  // namespace airclay
