// SPDX-License-Identifier: MIT
// What a rendered room contains, and how its cameras see it.
//
// Room frame: metres, z up, origin at the cube's centre. The desk's top is at kDeskZ; the person sits at the
// desk's side towards -y and looks towards +y.
#pragma once

#include "engine/camera/rig.h"
#include "engine/core/math.h"

namespace airclay {

inline constexpr double kDeskZ = -0.25;

/// sRGB, 0 to 1.
inline const Vec3 kLightSkin(0.90, 0.71, 0.62), kMediumSkin(0.76, 0.55, 0.42), kDarkSkin(0.36, 0.235, 0.18);

/// `count` (2 to 8) cameras of 640 x 480 pixels around the desk, about 1 m from the cube's centre, with the
/// lens distortion of webcams. Some look at the person, one looks down. `world_from_room` places the room in
/// the world; the cube keeps the world's axes.
Rig roomRig(int count, const Pose& world_from_room = Pose::Identity());

enum class Arm {
  kNone,    ///< the hand ends at the wrist
  kBare,    ///< bare to above the elbow
  kSleeve,  ///< a sleeve to near the wrist
};
enum class Desk {
  kWood,   ///< of a colour similar to skin
  kCloth,  ///< blue-green, unlike any skin
};
enum class Daylight {
  kSteady,
  kSlow,    ///< a cloud: the window's light falls to 60 % and returns
  kSudden,  ///< falls to 60 % within 0.1 s, in the middle of the recording
};
enum class BackgroundFrames {
  kNobody,  ///< the person appears with the first frame after them
  kSeated,  ///< the person sits at the desk, with the hand outside the cube
};

struct RoomOptions {
  Pose world_from_room = Pose::Identity();
  Rig rig = roomRig(4);
  std::uint32_t seed = 1;  ///< of the path, colours, drifts, clocks and noise

  double hand_scale = 1;   ///< about the origin of the hand frame
  Vec3 skin = kLightSkin;  ///< sRGB, 0 to 1

  Arm arm = Arm::kSleeve;
  double sleeve_from_wrist_m = 0.08;
  bool has_person = true;          ///< torso, head and upper arms; needs an arm
  bool has_second_person = false;  ///< walks next to the desk; needs the first
  Desk desk = Desk::kWood;
  bool has_shadows = true;  ///< of hand and person on the desk

  double rate_hz = 30;
  int background_frames = 10;
  BackgroundFrames background = BackgroundFrames::kNobody;
  int hand_frames = 90;  ///< after the background
  /// Of the wrist between places in the cube; it enters and leaves at up to 1 m/s.
  double peak_speed_m_s = 0.6;
  double still_s = 1;  ///< how long the hand rests in the cube; 0: not at all

  double exposure_s = 1.0 / 80;  ///< motion blur; 0: none
  double noise_dark = 1.2;       ///< standard deviation at black, on a scale of 255
  double noise_bright = 3.2;     ///< standard deviation at white
  double exposure_drift =
      0.08;  ///< relative amplitude of the images' brightness, different per camera; 0 at the start
  double white_balance_drift = 0.03;  ///< relative amplitude of red, and of blue in the opposite direction
  Daylight daylight = Daylight::kSteady;
  double clock_spread_s = 0;  ///< the cameras' offsets are distributed over this time; 0: synchronised
};

}  // namespace airclay
