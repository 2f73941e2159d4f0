// SPDX-License-Identifier: MIT
#include "engine/synthetic/room_script.h"

#include <cmath>
#include <numbers>

#include "engine/synthetic/person.h"

namespace airclay {
namespace {

/// The wrist's path is a minimum-jerk movement: its peak speed is this times its mean speed.
constexpr double kPeakOverMean = 1.875;
constexpr double kPeakTurnRadPerS = 5;
/// From the place of rest to the cube and back.
constexpr double kReachS = 1.3;

double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

/// The wrist at `wrist`, the fingers at `yaw` from +y (positive to the left) and `pitch` above the
/// horizontal; `roll` about the fingers, 0 for palm down, positive for thumb up.
Pose wristPose(const Vec3& wrist, double yaw, double pitch, double roll) {
  Pose pose = Pose::Identity();
  pose.linear() =
      (Eigen::AngleAxisd(radians(90 + yaw), Vec3::UnitZ()) *
       Eigen::AngleAxisd(radians(-pitch), Vec3::UnitY()) * Eigen::AngleAxisd(radians(roll), Vec3::UnitX()))
          .toRotationMatrix();
  pose.translation() = wrist;
  return pose;
}

/// The wrist bends by less than 55°. The hand's centre is within 14 cm of the cube's, so the hand is inside
/// the cube's inscribed sphere: the cube may have any orientation relative to the desk.
Pose randomPose(Random& random) {
  for (;;) {
    const double yaw = random.uniform(-45, 55), pitch = random.uniform(-40, 35),
                 roll = random.uniform(-60, 120);
    const Vec3 center(random.uniform(-0.12, 0.12), random.uniform(-0.12, 0.10), random.uniform(-0.10, 0.12));
    Pose pose = wristPose(Vec3::Zero(), yaw, pitch, roll);
    pose.translation() = center - pose.linear() * Vec3(0.08, 0, 0);
    const Vec3 forearm = (pose.translation() - armJoints(pose, 1).elbow).normalized();
    const double wrist_bend = std::acos(std::clamp(forearm.dot(pose.linear().col(0)), -1., 1.));
    if (center.norm() < 0.14 && wrist_bend < radians(55)) return pose;
  }
}

double durationOf(const Pose& from, const Pose& to, const RoomPath& path) {
  const double shift_m = (to.translation() - from.translation()).norm();
  const double turn = angleBetween(from.linear(), to.linear());
  return std::max(
      {kPeakOverMean * shift_m / path.peak_speed_m_s, kPeakOverMean * turn / kPeakTurnRadPerS, 0.2});
}

}  // namespace

HandScript roomScript(const RoomPath& path) {
  Random random(path.seed);
  const Pose rest = wristPose({0.27, -0.66, -0.22}, 70, -5, 25);
  std::vector<HandMove> moves;
  Pose at = randomPose(random);
  moves.push_back({kReachS, at, Vec3(0, 0, 0.04)});
  double time_s = path.begins_s + kReachS;
  const auto reach = [&](double latest_s) {
    const Pose next = randomPose(random);
    const double duration_s = durationOf(at, next, path);
    if (time_s + duration_s > latest_s) return false;
    const double bend_m = 0.1 * (next.translation() - at.translation()).norm();
    const Vec3 bend(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    moves.push_back({duration_s, next, bend_m * bend});
    time_s += duration_s;
    at = next;
    return true;
  };
  const double leaves_s = path.ends_s - kReachS;
  reach(leaves_s - path.still_s);
  if (path.still_s > 0) {
    moves.push_back({path.still_s, at});
    time_s += path.still_s;
  }
  for (int tries = 0; tries < 20; ++tries) reach(leaves_s);
  if (time_s < leaves_s) moves.push_back({leaves_s - time_s, at});
  moves.push_back({kReachS, rest, Vec3(0, 0, 0.04)});
  return HandScript(path.begins_s, rest, std::move(moves));
}

}  // namespace airclay
