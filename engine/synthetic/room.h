// SPDX-License-Identifier: MIT
// A hand over a desk in a lived-in room, as a rig's cameras would record it: a person behind the hand, soft
// shadows, changing light, drifting exposure and white balance, motion blur, noise, and clocks of their own.
// Rendered on the CPU: equal options give the same images on every device.
#pragma once

#include <memory>
#include <span>

#include "engine/hand/hand_model.h"
#include "engine/synthetic/room_options.h"

namespace airclay {

class Room {
 public:
  /// A hand in its rest pose, right or left.
  Room(const HandModel& hand, const RoomOptions& options);
  ~Room();
  Room(Room&&) noexcept;

  /// The true world_from_hand: of the hand model, scaled about its frame's origin. Empty while there is no
  /// hand.
  std::optional<Pose> handAt(double time_s) const;
  /// Whether the whole hand is inside the cube.
  bool isHandInCube(double time_s) const;

  /// The cameras' capture times (middle of the exposure) of a frame, in the rig's order.
  std::vector<double> cameraTimesOf(int frame) const;
  /// The factors of a camera's red, green and blue: exposure and white balance.
  Vec3 gainAt(std::size_t camera, double time_s) const;
  /// The factor of the window's light.
  double daylightAt(double time_s) const;

  /// Renders a camera's image of a frame, BGR, 3 bytes per pixel, rows from the top. Different cameras can be
  /// rendered at the same time on different threads.
  void render(std::size_t camera, int frame, std::span<std::uint8_t> bgr);
  /// Of the camera's last image: the fraction of each pixel in which the hand's skin is visible, row by row.
  std::vector<float> handCoverage(std::size_t camera) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace airclay
