// SPDX-License-Identifier: MIT
#include "engine/synthetic/script.h"

#include <gtest/gtest.h>

#include "engine/hand/hand_model.h"

namespace airclay {
namespace {

constexpr double kTubeRadius = 0.08, kTubeTop = 0.1;  // metres: the preset `tube`

/// Calls `use(time, pose)` every 5 ms while the hand is visible.
template <class Use>
void walk(const HandScript& script, Use use) {
  for (double time_s = 0; time_s <= script.endSeconds() + 0.2; time_s += 0.005)
    if (const auto pose = script.at(time_s)) use(time_s, *pose);
}

TEST(Script, HandAppearsAfterTheBackgroundFrames) {
  const HandScript script = demoScript();
  EXPECT_FALSE(script.at(9.0 / 30));
  EXPECT_TRUE(script.at(10.0 / 30));
  EXPECT_TRUE(script.at(1000));
  EXPECT_GT(script.endSeconds(), 4.5);
  EXPECT_LT(script.endSeconds(), 6);
}

TEST(Script, MotionIsSlowAndSmooth) {
  const HandScript script = demoScript();
  constexpr double h = 1e-3;
  walk(script, [&](double time_s, const Pose& pose) {
    const auto before = script.at(time_s - h), after = script.at(time_s + h);
    if (!before) return;
    const double speed = (after->translation() - before->translation()).norm() / (2 * h);
    EXPECT_LT(speed, 0.5) << "metres a second at " << time_s;
    const double turning = angleBetween(before->linear(), after->linear()) / (2 * h);
    EXPECT_LT(turning * 180 / M_PI, 120) << "degrees a second at " << time_s;
    // at this speed, a corner in the path would be 100 m/s² and more
    const Vec3 acceleration =
        (after->translation() - 2 * pose.translation() + before->translation()) / (h * h);
    EXPECT_LT(acceleration.norm(), 10) << "metres a second squared at " << time_s;
    EXPECT_LT((pose.linear().transpose() * pose.linear() - Mat3::Identity()).norm(), 1e-9);
  });
}

TEST(Script, HandStaysInsideTheWorkspace) {
  const TriangleMesh skin = builtInHand(false).skin;
  double farthest = 0;
  walk(demoScript(), [&](double, const Pose& world_from_hand) {
    for (const Vec3& vertex : skin.vertices)
      farthest = std::max(farthest, (world_from_hand * vertex).cwiseAbs().maxCoeff());
  });
  EXPECT_LT(farthest, 0.295);
}

TEST(Script, HandStartsAwayFromTheClayThenPushesSideAndRim) {
  const TriangleMesh skin = builtInHand(false).skin;
  const HandScript script = demoScript();
  // the skin's depth inside the solid cylinder, from its side or its top
  double side = 0, top = 0;
  walk(script, [&](double time_s, const Pose& world_from_hand) {
    double from_side = 0, from_top = 0;
    for (const Vec3& vertex : skin.vertices) {
      const Vec3 p = world_from_hand * vertex;
      const double radial = kTubeRadius - p.head<2>().norm(), vertical = kTubeTop - p.z();
      if (p.z() < -kTubeTop || radial < 0 || vertical < 0) continue;
      if (p.z() < 0.5 * kTubeTop)
        from_side = std::max(from_side, radial);
      else if (radial < 0.03)
        from_top = std::max(from_top, vertical);
    }
    if (time_s < 1) {
      EXPECT_EQ(from_side + from_top, 0) << "at " << time_s;
    }
    if (time_s < 2.5) side = std::max(side, from_side);
    if (time_s > 4) top = std::max(top, from_top);
  });
  EXPECT_GT(side, 0.02);
  EXPECT_LT(side, 0.04);
  EXPECT_GT(top, 0.02);
  EXPECT_LT(top, 0.04);
}

}  // namespace
}  // namespace airclay
