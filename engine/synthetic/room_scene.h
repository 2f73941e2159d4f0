// SPDX-License-Identifier: MIT
// The room without the person: desk, floor, walls, a box and a cup, as a camera sees them, and soft shadows
// on the desk.
#pragma once

#include <span>

#include "engine/synthetic/person.h"

namespace airclay {

/// What a camera sees of the empty room. Linear light; row by row.
struct RoomView {
  std::vector<Vec3f> ambient,
      window;  ///< light received from everywhere and from the window, times the albedo
  std::vector<Eigen::Vector2f> desk;  ///< where on the desk the pixel's centre is: x, y; NaN: elsewhere
  /// The depth along the camera's axis at the centre of each quadrant of each pixel: (0, 0), (1, 0), (0, 1),
  /// (1, 1).
  std::array<std::vector<float>, 4> depth_m;
};

/// The fraction of the light that reaches the desk, on a grid over it.
class DeskShadow {
 public:
  DeskShadow();  ///< without shadows
  void add(const Vec3& center_in_room, double radius_m, const Vec3& to_window);
  /// Bilinear: of the ambient light and of the window's. 1 outside.
  Eigen::Vector2f at(const Eigen::Vector2f& on_desk) const;

 private:
  int columns_, rows_;
  std::vector<Eigen::Vector2f> cells_;
};

class RoomScene {
 public:
  explicit RoomScene(const RoomOptions& options);

  /// `camera_from_room` is in place of camera_from_world.
  RoomView view(const Camera& camera) const;
  const Vec3& toWindow() const { return to_window_; }  ///< unit, room frame

 private:
  struct Hit {
    double distance_m;
    Vec3 point, normal;
    int surface;
  };
  Hit trace(const Vec3& eye, const Vec3& direction) const;
  Vec3f albedo(const Hit& hit) const;

  Desk desk_;
  NoiseVolume noise_;
  Vec3 to_window_;
  Pose room_from_box_ = Pose::Identity();
  Vec3 cup_;
  Vec3f wood_light_, wood_dark_, wall_, floor_, box_, poster_a_, poster_b_;
  double turn_ = 0;  // of the wood's grain
};

/// The light of the room: ambient is for an unobstructed surface that faces up, window for one that faces the
/// window.
inline constexpr float kAmbientLight = 0.42f, kWindowLight = 0.62f;

}  // namespace airclay
