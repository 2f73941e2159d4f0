// SPDX-License-Identifier: MIT
// Contact: simple solids sweep a plane of points whose targets are known; the kernel is compared with its
// reference.
#include "engine/sculpt/contact.h"

#include <cmath>
#include <random>

#include "tests/support/contact_hands.h"
#include "tests/support/gpu_fixture.h"

namespace airclay {
namespace {

constexpr double kBallRadius_m = 0.03;

/// Points of the plane z = 0 about the origin, 3 mm apart.
std::vector<vec3> planePoints() {
  std::vector<vec3> points;
  for (int y = -20; y <= 20; ++y)
    for (int x = -20; x <= 20; ++x) points.emplace_back(0.003f * float(x), 0.003f * float(y), 0.0f);
  return points;
}

ContactPose poseOf(const GpuHandPose& fit) {
  return {Eigen::Quaterniond(Eigen::Vector4d(fit.rotation.cast<double>())), fit.position.cast<double>()};
}

/// Data points that only the test moves, and a hand.
struct Scene {
  Scene(const HandModel& hand, const std::vector<vec3>& data_points)
      : gpu(testGpu()),
        grid(contactGrid(hand.skin)),
        contact(gpu, grid, static_cast<std::uint32_t>(data_points.size())),
        finder(gpu, contact),
        data(gpu, data_points, Memory::kHost),
        fit(gpu, 1, Memory::kHost),
        recorder(gpu) {}

  /// The first check of a frame; returns the number of reached points.
  int frame(const GpuHandPose& hand_fit, bool held = true) {
    fit.host()[0] = hand_fit;
    recorder.begin();
    contact.recordBegin(recorder, fit, held);
    finder.recordCheck(recorder, data, true);
    recorder.submitAndWait();
    EXPECT_TRUE(hazards(recorder.commands()).empty());
    return static_cast<int>(contact.summary().touched);
  }

  /// The clay has moved: another check in the same frame.
  void check(const std::vector<vec3>& data_points) {
    data.upload(data_points);
    recorder.begin();
    finder.recordPush(recorder);
    finder.recordCheck(recorder, data, false);
    recorder.submitAndWait();
    EXPECT_TRUE(hazards(recorder.commands()).empty());
  }

  Vec3 target(const GpuContactPoint& point) const {
    return point.position.cast<double>() +
           poseOf(fit.host()[0]).rotation * (point.depth * point.direction).cast<double>();
  }

  Gpu& gpu;
  DistanceGrid grid;
  ContactFrame contact;
  ContactFinder finder;
  Buffer<vec3> data;
  Buffer<GpuHandPose> fit;
  Recorder recorder;
};

/// A ball moved down to `height` above the plane: the points in its way were reached and move to the ball's
/// lower half.
void expectBelowTheBall(const Scene& scene, double height) {
  int reached = 0;
  for (const GpuContactPoint& point : scene.finder.points()) {
    const double off_axis = std::hypot(point.position.x(), point.position.y());
    const bool in_path =
        off_axis < kBallRadius_m && (height < 0 || std::hypot(off_axis, height) < kBallRadius_m);
    const double margin = 0.0005;  // grazed points may be missed
    if (std::abs(off_axis - kBallRadius_m) < margin ||
        (height > 0 && std::abs(std::hypot(off_axis, height) - kBallRadius_m) < margin))
      continue;
    EXPECT_EQ(point.state == kPointReached, in_path) << point.position.transpose();
    if (!in_path) continue;
    ++reached;
    const Vec3 target = scene.target(point), center(0, 0, height);
    EXPECT_NEAR((target - center).norm(), kBallRadius_m, 1e-4);
    EXPECT_LE(target.z(), height) << "on the side that came first";
    EXPECT_LT((target - point.position.cast<double>()).head<2>().norm(), 1e-6) << "along the ball's way";
  }
  EXPECT_GT(reached, 200);
}

TEST(Contact, BallPushesAPlaneToItsFront) {
  Scene scene(ballHand(kBallRadius_m), planePoints());
  EXPECT_EQ(scene.frame(gpuHandAt({0, 0, 0.035})), 0);
  EXPECT_GT(scene.frame(gpuHandAt({0, 0, 0.01})), 0);
  expectBelowTheBall(scene, 0.01);
}

TEST(Contact, FastBallDoesNotPassThroughASheet) {
  Scene scene(ballHand(kBallRadius_m), planePoints());
  scene.frame(gpuHandAt({0, 0, 0.1}));
  scene.frame(gpuHandAt({0, 0, -0.15}));  // 25 cm in one frame, completely past the sheet
  expectBelowTheBall(scene, -0.15);
}

TEST(Contact, FastThinPlateKeepsItsSide) {
  // 4 mm thick
  Scene scene(boxHand({0.08, 0.08, 0.004}), planePoints());
  scene.frame(gpuHandAt({0, 0, 0.05}));
  scene.frame(gpuHandAt({0, 0, 0.0015}));  // half a millimetre deep
  scene.frame(gpuHandAt({0, 0, -0.02}));   // without memory, the points would come out at the plate's back
  int reached = 0;
  for (const GpuContactPoint& point : scene.finder.points()) {
    const double from_axis = point.position.head<2>().cwiseAbs().maxCoeff();
    if (from_axis > 0.041) {
      EXPECT_EQ(point.state, kPointOutside);
    }
    if (from_axis > 0.037) continue;  // the grid rounds the plate's edges
    ++reached;
    ASSERT_EQ(point.state, kPointReached);
    EXPECT_NEAR(scene.target(point).z(), -0.022, 1e-4);
  }
  EXPECT_GT(reached, 500);
}

TEST(Contact, RotatingThinPlateSweepsAnArc) {
  // a wing of 80 mm rotates by 60 degrees about the y axis: it reaches the points in its way, on its
  // lower face
  Scene scene(boxHand({0.08, 0.08, 0.004}),
              std::vector<vec3>{{0.03f, 0, -0.02f}, {0.03f, 0, 0.02f}, {-0.03f, 0, 0.02f}});
  const auto turned = [](double angle) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vec3::UnitY()));
  };
  scene.frame(gpuHandAt(Vec3::Zero(), turned(0)));
  EXPECT_EQ(scene.frame(gpuHandAt(Vec3::Zero(), turned(M_PI / 3))), 2);
  const std::vector<GpuContactPoint> points = scene.finder.points();
  EXPECT_EQ(points[0].state, kPointReached);  // the wing's right half goes down
  EXPECT_EQ(points[1].state, kPointOutside);
  EXPECT_EQ(points[2].state, kPointReached);  // and its left half up
  for (const int i : {0, 2}) {
    const Vec3 target_in_hand = turned(M_PI / 3).conjugate() * scene.target(points[std::size_t(i)]);
    // carried along by the skin that hit it: on its circle about the axis, on the leading face
    EXPECT_NEAR(target_in_hand.z(), i == 0 ? -0.002 : 0.002, 1e-4);
    EXPECT_NEAR(target_in_hand.norm(), points[std::size_t(i)].position.norm(), 1e-4);
  }
}

TEST(Contact, InitialPenetrationIsIgnoredUntilItEnds) {
  Scene scene(ballHand(kBallRadius_m), {{0, 0, 0}, {0, 0, -0.04f}});
  EXPECT_EQ(scene.frame(gpuHandAt({0, 0, 0})), 0);
  EXPECT_EQ(scene.frame(gpuHandAt({0, 0, -0.015})), 1);  // only the lower point
  std::vector<GpuContactPoint> points = scene.finder.points();
  EXPECT_EQ(points[0].state, kPointIgnored);
  EXPECT_EQ(points[1].state, kPointReached);
  EXPECT_EQ(scene.frame(gpuHandAt({0, 0, 0.0305})), 0);  // half a millimetre outside: not released yet
  EXPECT_EQ(scene.finder.points()[0].state, kPointIgnored);
  EXPECT_EQ(scene.frame(gpuHandAt({0, 0, 0.02})), 0);
  EXPECT_EQ(scene.frame(gpuHandAt({0, 0, 0.035})), 0);
  EXPECT_EQ(scene.frame(gpuHandAt({0, 0, 0.02})), 1);
  EXPECT_EQ(scene.finder.points()[0].state, kPointReached);
}

TEST(Contact, LostFramesAndOpenClutchMoveNothing) {
  for (const bool lose : {true, false}) {
    Scene scene(ballHand(kBallRadius_m), planePoints());
    scene.frame(gpuHandAt({0, 0, 0.05}));
    EXPECT_EQ(lose ? scene.frame(lostHand()) : scene.frame(gpuHandAt({0, 0, 0.03}), false), 0);
    EXPECT_EQ(scene.contact.summary().done, 1u);
    // it returns on the other side: its path is unknown
    EXPECT_EQ(scene.frame(gpuHandAt({0, 0, -0.05})), 0);
    // from here on its path is known again
    EXPECT_GT(scene.frame(gpuHandAt({0, 0, -0.02})), 0);
  }
  Scene scene(ballHand(kBallRadius_m), planePoints());
  scene.frame(gpuHandAt({0, 0, 0.05}));
  scene.contact.forget();
  EXPECT_EQ(scene.frame(gpuHandAt({0, 0, -0.05})), 0);
}

TEST(Contact, HandThatMovesAwayLetsGo) {
  Scene scene(ballHand(kBallRadius_m), planePoints());
  scene.frame(gpuHandAt({0, 0, 0.035}));
  EXPECT_GT(scene.frame(gpuHandAt({0, 0, 0.0299})), 0);
  EXPECT_GT(scene.frame(gpuHandAt({0, 0, 0.03005})), 0) << "0.05 mm away is not away";
  EXPECT_EQ(scene.frame(gpuHandAt({0, 0, 0.04})), 0);
}

TEST(Contact, EqualsTheReference) {
  const HandModel hand = builtInHand(false);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto vector = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  std::vector<vec3> data_points;
  for (int i = 0; i < 3000; ++i) data_points.push_back((0.1 * vector()).cast<float>());
  Scene scene(hand, data_points);

  GpuHandPose before = gpuHandAt({0.02, 0.01, 0.2});
  scene.frame(before);
  int compared = 0, reached = 0, different = 0;
  for (int frame = 0; frame < 12; ++frame) {
    const Eigen::Quaterniond rotation(Eigen::AngleAxisd(0.15 * frame, Vec3(1, 2, -1).normalized()));
    const GpuHandPose now =
        gpuHandAt(before.position.cast<double>() + Vec3(0, 0, -0.02) + 0.01 * vector(), rotation);
    for (int repeat = 0; repeat < 3; ++repeat) {
      const std::vector<GpuContactPoint> start = scene.finder.points();
      ContactMotion motion{repeat == 0 ? poseOf(before) : poseOf(now), poseOf(now), false, repeat == 0};
      if (repeat == 0) {
        scene.frame(now);
      } else {
        for (std::size_t i = 0; i < data_points.size(); ++i)
          data_points[i] += (scene.target(start[i]) - start[i].position.cast<double>()).cast<float>() * 0.3f;
        scene.check(data_points);
      }
      const std::vector<GpuContactPoint> end = scene.finder.points();
      for (std::size_t i = 0; i < end.size(); ++i) {
        // the kernel's push before the check is part of the state from which the check
        // starts
        ContactPoint point{start[i].position.cast<double>(),
                           start[i].state,
                           start[i].direction.cast<double>(),
                           start[i].depth,
                           0,
                           end[i].pushed};
        contactReference(scene.grid, motion, data_points[i].cast<double>(), point);
        ++compared;
        reached += point.state == kPointReached;
        const bool same = point.state == end[i].state &&
                          (point.state != kPointReached ||
                           (contactTarget(motion.now, point) - scene.target(end[i])).norm() < 1e-5);
        different += !same;
      }
    }
    before = now;
  }
  EXPECT_GT(reached, 1000);
  // a grazed surface, or one met at the end of a step, may be hit in one and not in the other
  EXPECT_LE(different, compared / 2000);
}

}  // namespace
}  // namespace airclay
