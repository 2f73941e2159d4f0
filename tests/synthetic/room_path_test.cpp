// SPDX-License-Identifier: MIT
// The hand's path over the desk, and the arm that follows it.
#include <gtest/gtest.h>

#include "engine/synthetic/person.h"
#include "engine/synthetic/room_script.h"

namespace airclay {
namespace {

constexpr double kStepS = 0.005;

/// The centre of a hand of 17 cm, and a ball that contains it.
const Vec3 kCenterInWrist(0.08, 0, 0);
constexpr double kHandRadius = 0.13;

RoomPath pathOf(std::uint32_t seed) {
  RoomPath path;
  path.seed = seed;
  path.begins_s = -0.25;
  path.ends_s = 3.8;
  path.peak_speed_m_s = 0.8;
  return path;
}

TEST(RoomPath, StaysBelowThePeakSpeedAndAboveTheDesk) {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const HandScript script = roomScript(pathOf(seed));
    double fastest_m_s = 0;
    for (double t = -0.25; t < 3.8; t += kStepS) {
      const Pose a = *script.at(t), b = *script.at(t + kStepS);
      const double height_m = (a * kCenterInWrist).z() - kDeskZ;
      if ((a * kCenterInWrist).norm() > 0.16) continue;  // on its way in or out
      EXPECT_GT(height_m, 0.09);
      fastest_m_s = std::max(fastest_m_s, (b.translation() - a.translation()).norm() / kStepS);
    }
    EXPECT_LT(fastest_m_s, 1.06);  // it leaves faster
    EXPECT_GT(fastest_m_s, 0.3);
  }
}

TEST(RoomPath, EntersRestsForASecondTurnsAboutAllAxesAndLeaves) {
  Vec3 turned = Vec3::Zero();
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const HandScript script = roomScript(pathOf(seed));
    // neither the beginning nor the end is in any rotated cube
    for (const double t : {-0.25, 3.8})
      EXPECT_GT((*script.at(t) * kCenterInWrist).norm() - kHandRadius, 0.3 * std::sqrt(3) - 0.08);
    double still_s = 0, longest_s = 0;
    for (double t = -0.25; t < 3.8; t += kStepS) {
      const Pose a = *script.at(t), b = *script.at(t + kStepS);
      const bool rests = (a.matrix() - b.matrix()).norm() < 1e-9 && (a * kCenterInWrist).norm() < 0.15;
      still_s = rests ? still_s + kStepS : 0;
      longest_s = std::max(longest_s, still_s);
      const Eigen::AngleAxisd turn(Mat3(a.linear().transpose() * b.linear()));
      turned += (turn.angle() * turn.axis()).cwiseAbs();
    }
    EXPECT_GE(longest_s, 0.98);
  }
  EXPECT_GT(turned.minCoeff() / 20, 1) << "radians per take about " << turned.transpose();
}

TEST(Person, ForearmEndsAtTheWristAndLimbsKeepTheirLengths) {
  const Person person(builtInHand(false), {});
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    const HandScript script = roomScript(pathOf(seed));
    std::optional<Vec3> elbow_before;
    for (double t = -0.25; t < 3.8; t += kStepS) {
      const Pose room_from_wrist = *script.at(t);
      const BonePoses poses = person.poses(room_from_wrist);
      const auto at = [&](Bone bone) { return poses[static_cast<std::size_t>(bone)]; };
      const Pose hand = at(Bone::kHand) * person.handFromWrist();
      EXPECT_LT((hand.matrix() - room_from_wrist.matrix()).norm(), 1e-12);
      const Vec3 wrist = at(Bone::kForearm).translation(), elbow = at(Bone::kUpperArm).translation();
      EXPECT_LT((wrist - room_from_wrist.translation()).norm(), 1e-12);
      EXPECT_NEAR((wrist - elbow).norm(), 0.27, 1e-6);
      EXPECT_LT((at(Bone::kForearm).inverse() * elbow - Vec3(-0.27, 0, 0)).norm(), 1e-6);
      if (elbow_before) {
        EXPECT_LT((elbow - *elbow_before).norm() / kStepS, 6) << "at " << t << " s";
      }
      elbow_before = elbow;
    }
  }
}

TEST(Person, TellsLeftHandsFromRightOnes) {
  EXPECT_FALSE(isLeftHand(builtInHand(false)));
  EXPECT_TRUE(isLeftHand(builtInHand(true)));
}

TEST(Person, LeftHandIsTheMirrorImage) {
  const Person right(builtInHand(false), {}), left(builtInHand(true), {});
  const Pose room_from_wrist = *roomScript(pathOf(3)).at(1);
  const Pose mirrored = left.sided(room_from_wrist);
  EXPECT_EQ(right.sided(room_from_wrist).matrix(), room_from_wrist.matrix());
  const BonePoses of_right = right.poses(room_from_wrist), of_left = left.poses(mirrored);
  const auto& a = right.mesh();
  const auto& b = left.mesh();
  ASSERT_EQ(a.positions.size(), b.positions.size());
  // the hand's vertices correspond
  for (std::size_t i = 0; i < a.parts.front().count; i += 50) {
    const Vec3 p = of_right[0] * a.positions[i].cast<double>(),
               q = of_left[0] * b.positions[i].cast<double>();
    EXPECT_LT((Vec3(-p.x(), p.y(), p.z()) - q).norm(), 1e-5);
  }
}

}  // namespace
}  // namespace airclay
