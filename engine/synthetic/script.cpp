// SPDX-License-Identifier: MIT
#include "engine/synthetic/script.h"

#include <cmath>

namespace airclay {
namespace {

/// world_from_hand with the wrist at `wrist`, the fingers along `fingers` and the back of the hand towards
/// `back` (made perpendicular).
Pose handPose(const Vec3& wrist, const Vec3& fingers, const Vec3& back) {
  const Vec3 x = fingers.normalized(), z = (back - x * x.dot(back)).normalized();
  Pose world_from_hand = Pose::Identity();
  world_from_hand.linear() << x, z.cross(x), z;
  world_from_hand.translation() = wrist;
  return world_from_hand;
}

double minimumJerk(double t) {
  return t * t * t * (10 + t * (-15 + 6 * t));
}

Pose along(const Pose& from, const HandMove& move, double t) {
  const double s = minimumJerk(t);
  const Eigen::Quaterniond a(from.linear()), b(move.world_from_hand.linear());
  Pose pose = Pose::Identity();
  pose.linear() = a.slerp(s, b).toRotationMatrix();
  pose.translation() = (1 - s) * from.translation() + s * move.world_from_hand.translation() +
                       16 * s * s * (1 - s) * (1 - s) * move.midpoint_offset_m;
  return pose;
}

}  // namespace

HandScript::HandScript(double appears_s, const Pose& start, std::vector<HandMove> moves)
    : appears_s_(appears_s), start_(start), moves_(std::move(moves)) {}

std::optional<Pose> HandScript::at(double time_s) const {
  if (time_s < appears_s_) return std::nullopt;
  double begins_s = appears_s_;
  Pose pose = start_;
  for (const HandMove& move : moves_) {
    if (time_s < begins_s + move.duration_s) return along(pose, move, (time_s - begins_s) / move.duration_s);
    begins_s += move.duration_s;
    pose = move.world_from_hand;
  }
  return pose;
}

double HandScript::endSeconds() const {
  double end_s = appears_s_;
  for (const HandMove& move : moves_) end_s += move.duration_s;
  return end_s;
}

HandScript demoScript() {
  // The arm comes from -y. At first the thumb is up and the palm faces the tube, which is on its -x side. The
  // tube's radius is 8 cm; its rim is 10 cm above the centre.
  const Vec3 up = Vec3::UnitZ(), ahead = Vec3::UnitY(), aside = Vec3::UnitX();
  const Pose start = handPose({0.20, -0.24, 0.02}, ahead + 0.25 * aside - 0.1 * up, aside + 0.35 * up);
  const Pose beside = handPose({0.135, -0.150, -0.015}, ahead + 0.05 * aside, aside + 0.1 * up);
  const Pose pressed_in = handPose({0.068, -0.140, -0.010}, ahead - 0.05 * aside, aside);
  const Pose away = handPose({0.165, -0.200, 0.03}, ahead + 0.15 * aside, aside + 0.3 * up);
  const Pose above = handPose({0.005, -0.225, 0.195}, ahead - 0.15 * up, up);
  const Pose pressed_down = handPose({0.000, -0.205, 0.120}, ahead - 0.22 * up, up);
  const Pose end = handPose({0.060, -0.240, 0.185}, ahead - 0.05 * up, up + 0.3 * aside);
  const double appears_s = 10.0 / 30;
  return HandScript(appears_s, start,
                    {{0.2, start},
                     {0.75, beside},
                     {0.6, pressed_in},
                     {0.15, pressed_in},
                     {0.65, away},
                     {1.35, above, {0.06, 0, 0.05}},
                     {0.55, pressed_down},
                     {0.15, pressed_down},
                     {0.7, end}});
}

}  // namespace airclay
