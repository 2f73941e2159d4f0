// SPDX-License-Identifier: MIT
#include "capture/takes/room_set.h"

#include "engine/synthetic/texture.h"

namespace airclay {
namespace {

/// A hand alone over a cloth, without noise or shadows, seen by ideal cameras.
RoomOptions cleanOptions() {
  RoomOptions options;
  options.arm = Arm::kNone;
  options.desk = Desk::kCloth;
  options.has_shadows = false;
  options.exposure_s = 0;
  options.noise_dark = options.noise_bright = 0;
  options.exposure_drift = options.white_balance_drift = 0;
  return options;
}

/// A person at a wooden desk, with noise; the light does not change.
RoomOptions personOptions() {
  RoomOptions options;
  options.has_shadows = false;
  options.exposure_s = 0;
  options.exposure_drift = options.white_balance_drift = 0;
  return options;
}

Pose randomRotation(std::uint32_t seed) {
  Random random(seed);
  Vec3 axis;
  do axis = Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
  while (axis.norm() > 1 || axis.norm() < 0.1);
  Pose pose = Pose::Identity();
  pose.linear() = rotationFromVector(random.uniform(0.3, 3.1) * axis.normalized());
  return pose;
}

}  // namespace

std::vector<RoomTake> standardRooms() {
  std::vector<RoomTake> takes;
  const auto add = [&](const std::string& name, const std::string& contents, RoomOptions options,
                       int cameras = 4) {
    options.seed = static_cast<std::uint32_t>(takes.size()) + 1;
    options.world_from_room = randomRotation(options.seed);
    options.rig = roomRig(cameras, options.world_from_room);
    takes.push_back({name, contents, options});
  };
  const auto with = [](RoomOptions options, auto member, auto value) {
    options.*member = value;
    return options;
  };
  const RoomOptions clean = cleanOptions(), person = personOptions();

  add("clean-2", "a hand over a cloth, 2 cameras", clean, 2);
  add("clean-4", "4 cameras", clean);
  add("clean-8", "8 cameras", clean, 8);
  RoomOptions noise = clean;
  noise.noise_dark = 2;
  noise.noise_bright = 5;
  add("noise", "strong camera noise", noise);
  add("scale-0.93", "a hand 7 % smaller than the model", with(clean, &RoomOptions::hand_scale, 0.93));
  add("scale-1.07", "7 % larger", with(clean, &RoomOptions::hand_scale, 1.07));
  add("fast", "up to 0.8 m/s", with(clean, &RoomOptions::peak_speed_m_s, 0.8));
  RoomOptions forearm = clean;
  forearm.arm = Arm::kBare;
  forearm.has_person = false;
  add("forearm", "a bare forearm", forearm);

  add("person", "a person at a wooden desk, sleeve near the wrist", person);
  add("skin-medium", "medium skin", with(person, &RoomOptions::skin, kMediumSkin));
  add("skin-dark", "dark skin", with(person, &RoomOptions::skin, kDarkSkin));
  add("bare-arm", "a bare arm", with(person, &RoomOptions::arm, Arm::kBare));
  add("shadows", "soft shadows on the desk", with(person, &RoomOptions::has_shadows, true));
  RoomOptions drift = person;
  drift.exposure_drift = 0.08;
  drift.white_balance_drift = 0.03;
  add("exposure-drift", "automatic exposure and white balance drift by 8 % and 3 %", drift);
  add("daylight", "the window's light falls suddenly to 60 %",
      with(person, &RoomOptions::daylight, Daylight::kSudden));
  add("motion-blur", "exposed for 1/60 s", with(person, &RoomOptions::exposure_s, 1.0 / 60));
  add("unsynchronised", "the cameras' clocks are up to 33 ms apart",
      with(person, &RoomOptions::clock_spread_s, 0.033));

  add("second-person", "somebody walks next to the desk",
      with(person, &RoomOptions::has_second_person, true));
  add("seated", "the person is there while the background is learned",
      with(person, &RoomOptions::background, BackgroundFrames::kSeated));

  RoomOptions everything;
  everything.skin = kMediumSkin;
  everything.arm = Arm::kBare;
  everything.exposure_s = 1.0 / 60;
  everything.peak_speed_m_s = 0.8;
  everything.clock_spread_s = 0.033;
  everything.daylight = Daylight::kSlow;
  everything.hand_scale = 1.05;
  add("everything", "all of these at once", everything);
  return takes;
}

}  // namespace airclay
