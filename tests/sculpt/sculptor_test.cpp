// SPDX-License-Identifier: MIT
// Contact, solve and subdivision together: a ball and the built-in hand press into clay.
#include "engine/sculpt/sculptor.h"

#include <algorithm>
#include <cmath>

#include "engine/clay/presets.h"
#include "engine/core/error.h"
#include "tests/support/contact_hands.h"
#include "tests/support/gpu_fixture.h"

namespace airclay {
namespace {

constexpr double kBallRadius_m = 0.03;

/// Clay, hand and everything a frame needs.
struct Workshop {
  Workshop(const std::string& preset, int levels, const SolveMethod* rows, const HandModel& hand,
           const Vec3& workspace_center = Vec3::Zero())
      : gpu(testGpu()),
        skin(hand.skin),
        clay(gpu, ClayState{presetCage(preset), SubdivisionRule::kCatmullClark, levels, rows},
             workspace_center),
        sculptor(gpu, clay, hand),
        fit(gpu, 1, Memory::kHost),
        recorder(gpu) {}

  ClayStep frame(const GpuHandPose& hand_fit, bool held = true) {
    fit.host()[0] = hand_fit;
    recorder.begin();
    sculptor.record(recorder, fit, {.held = held});
    recorder.submitAndWait();
    EXPECT_TRUE(hazards(recorder.commands()).empty());
    if (sculptor.needsHost()) {
      sculptor.finishOnHost(recorder);
      EXPECT_TRUE(hazards(recorder.commands()).empty());
    }
    return sculptor.step();
  }

  /// Depth of the surface's deepest point inside the hand, computed only from surface and hand.
  double deepest() {
    if (grid.values.empty()) grid = contactGrid(skin);
    const GpuHandPose& hand = fit.host()[0];
    const Eigen::Quaterniond rotation(Eigen::Vector4d(hand.rotation.cast<double>()));
    double deepest = 0;
    for (const vec3& point : clay.dataPoints().download())
      deepest =
          std::max(deepest, -sample(grid, rotation.conjugate() * (point - hand.position).cast<double>()));
    return deepest;
  }

  Gpu& gpu;
  TriangleMesh skin;
  Clay clay;
  Sculptor sculptor;
  DistanceGrid grid;
  Buffer<GpuHandPose> fit;
  Recorder recorder;
};

/// A ball next to the tube's wall, 70 mm from its axis, pushed in by `push`.
GpuHandPose ballAt(double push) {
  return gpuHandAt(Vec3(0.07 + kBallRadius_m + 0.002 - push, 0, 0.01));
}

double largestMove(const PolygonMesh& before, const PolygonMesh& after, bool far_side) {
  double largest = 0;
  for (std::size_t i = 0; i < before.points.size(); ++i)
    if (!far_side || before.points[i].x() < -0.03)
      largest = std::max(largest, (after.points[i] - before.points[i]).norm());
  return largest;
}

TEST(Sculptor, BallPushesTheTubeIn) {
  for (const SolveMethod* rows : {&kSolveAll, &kSolveTouched}) {
    Workshop workshop("tube", 2, rows, ballHand(kBallRadius_m));
    const PolygonMesh before = workshop.clay.surface();
    workshop.frame(ballAt(0));
    for (int i = 1; i <= 10; ++i) {
      const ClayStep step = workshop.frame(ballAt(0.003 * i));
      EXPECT_LT(step.penetration_m, 0.001) << i;
      EXPECT_LT(workshop.deepest(), 0.001) << i;
      EXPECT_GT(step.touched, 0) << i;
      EXPECT_LE(step.repeats, int(kContactMaxRepeats)) << i;
    }
    const PolygonMesh after = workshop.clay.surface();
    EXPECT_GT(largestMove(before, after, false), 0.025) << "28 mm were pushed";
    EXPECT_LT(largestMove(before, after, true), 0.005);
    // surface and normals belong to the cage
    const std::vector<Vec3> points =
        dataPoints(workshop.clay.subdivision().matrix, workshop.clay.cage().points);
    const std::vector<Vec3> normals = dataNormals(workshop.clay.subdivision().quads, points);
    const std::vector<vec3> gpu_normals = workshop.clay.normals().download();
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_LT((after.points[i] - points[i]).norm(), 1e-7);
      EXPECT_LT((gpu_normals[i].cast<double>() - normals[i]).norm(), 1e-4);
    }
  }
}

TEST(Sculptor, FollowsAFastBall) {
  // 1 and 2 cm per frame: the surface leaves the ball within 32 repeats
  for (const double step_m : {0.01, 0.02}) {
    Workshop workshop("tube", 2, &kSolveAll, ballHand(kBallRadius_m));
    workshop.frame(ballAt(0));
    for (int i = 1; i * step_m <= 0.041; ++i) {
      const ClayStep step = workshop.frame(ballAt(step_m * i));
      EXPECT_LT(step.penetration_m, 0.001) << step_m << ' ' << i;
      EXPECT_LT(workshop.deepest(), 0.001);
    }
  }
}

TEST(Sculptor, SinglePointEndsOnTheHand) {
  // the tip of an 8 mm rod against one data point: accelerated repeats must not throw it off the rod
  Workshop workshop("tube", 2, &kSolveAll, boxHand({0.2, 0.008, 0.008}));
  const std::vector<vec3> points = workshop.clay.dataPoints().download();
  const auto nearest = std::min_element(points.begin(), points.end(), [](const vec3& a, const vec3& b) {
    const vec3 target(0.07f, 0, 0);
    return (a - target).norm() < (b - target).norm();
  });
  const Vec3 before = nearest->cast<double>();
  const auto index = static_cast<std::size_t>(nearest - points.begin());
  workshop.frame(gpuHandAt(Vec3(before.x() + 0.101, before.y(), before.z())));
  const ClayStep step = workshop.frame(gpuHandAt(Vec3(before.x() + 0.09, before.y(), before.z())));
  EXPECT_EQ(step.touched, 1);
  EXPECT_LE(step.repeats, 4);
  // the grid rounds the tip by at most a tenth of a millimetre in its middle
  EXPECT_NEAR(workshop.clay.dataPoints().download()[index].x(), before.x() - 0.01, 0.0005 + 0.0001);
}

TEST(Sculptor, TheSameFramesGiveTheSameBits) {
  std::vector<std::vector<vec3>> runs;
  for (int run = 0; run < 2; ++run) {
    Workshop workshop("vase", 2, &kSolveAll, builtInHand(false));
    int repeats = 0;
    for (int i = 0; i <= 6; ++i) {
      const Eigen::Quaterniond rotation(Eigen::AngleAxisd(M_PI + 0.05 * i, Vec3(0, 0.1, 1).normalized()));
      repeats += workshop.frame(gpuHandAt(Vec3(0.23 - 0.02 * i, 0, 0), rotation)).repeats;
    }
    EXPECT_GT(repeats, 5) << "the hand must have done something";
    runs.push_back(workshop.clay.dataPoints().download());
  }
  EXPECT_EQ(std::memcmp(runs[0].data(), runs[1].data(), runs[0].size() * sizeof(vec3)), 0);
}

TEST(Sculptor, NothingMovesWithoutHandAndClutch) {
  Workshop workshop("tube", 2, &kSolveAll, ballHand(kBallRadius_m));
  const PolygonMesh before = workshop.clay.surface();
  workshop.frame(ballAt(0));
  for (int i = 1; i <= 3; ++i) {
    const ClayStep open = workshop.frame(ballAt(0.01 * i), false);
    EXPECT_EQ(open.touched + open.repeats, 0);
  }
  EXPECT_EQ(workshop.frame(lostHand()).repeats, 0);
  EXPECT_EQ(workshop.frame(ballAt(0.02)).repeats, 0);  // it starts inside the clay: ignored
  EXPECT_EQ(workshop.frame(ballAt(0.0205)).penetration_m, 0);
  workshop.frame(ballAt(-0.01));
  EXPECT_LT(largestMove(before, workshop.clay.surface(), false), 0.001);
  EXPECT_GT(workshop.frame(ballAt(0.01)).repeats, 0) << "it has left, and comes again";
}

TEST(Sculptor, AppliesWorkspaceCentreAndNewControlPoints) {
  const Vec3 center(1, -2, 3);
  const PolygonMesh cage = presetCage("tube");
  Workshop workshop("tube", 2, &kSolveAll, ballHand(kBallRadius_m), center);
  const std::vector<vec3> in_workspace = workshop.clay.dataPoints().download();
  const std::vector<Vec3> points = dataPoints(workshop.clay.subdivision().matrix, cage.points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_LT((in_workspace[i].cast<double>() + center - points[i]).norm(), 1e-6);
    EXPECT_LT((workshop.clay.surface().points[i] - points[i]).norm(), 1e-6);
  }
  EXPECT_EQ(workshop.clay.cage().faces, cage.faces);

  // control points moved to the hand are not a touch
  const GpuHandPose inside = gpuHandAt(-center + Vec3(0.02, 0, 0));
  workshop.frame(inside);
  EXPECT_EQ(workshop.frame(inside).touched, 0);
  std::vector<Vec3> moved = cage.points;
  for (Vec3& point : moved) point += Vec3(-0.06, 0, 0);
  workshop.clay.setControlPoints(moved);
  EXPECT_EQ(workshop.frame(inside).touched, 0);
  EXPECT_EQ(workshop.frame(inside).touched, 0);
  for (std::size_t i = 0; i < moved.size(); ++i)
    EXPECT_LT((workshop.clay.cage().points[i] - moved[i]).norm(), 1e-12);
  EXPECT_THROW(workshop.clay.setControlPoints({}), Error);
}

TEST(Sculptor, ClayRotatesAboutTheWorkspaceCentre) {
  const Vec3 center(1, -2, 3);
  const Eigen::Quaterniond about_z(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ()));
  const PolygonMesh cage = presetCage("tube");
  Workshop workshop("tube", 2, &kSolveAll, ballHand(kBallRadius_m), center);
  const PolygonMesh before = workshop.clay.surface();
  const auto expectTurned = [&](const std::vector<Vec3>& now, const std::vector<Vec3>& then) {
    for (std::size_t i = 0; i < then.size(); ++i) {
      const Vec3 from_center = then[i] - center;
      EXPECT_LT((now[i] - center - Vec3(-from_center.y(), from_center.x(), from_center.z())).norm(), 1e-12);
    }
  };
  workshop.clay.rotate(about_z);
  expectTurned(workshop.clay.cage().points, cage.points);
  expectTurned(workshop.clay.surface().points, before.points);
  // in the same frame, and in another one
  workshop.clay.setControlPoints(cage.points);
  for (std::size_t i = 0; i < cage.points.size(); ++i)
    EXPECT_LT((workshop.clay.cage().points[i] - cage.points[i]).norm(), 1e-12);
  EXPECT_TRUE(workshop.clay.workspaceFromClay().isApprox(about_z));
  workshop.clay.setControlPoints(cage.points, Eigen::Quaterniond::Identity());
  workshop.clay.rotate(about_z);
  expectTurned(workshop.clay.cage().points, cage.points);

  // clay that rotates into the hand is not touched by it
  const Eigen::Quaterniond about_x(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitX()));
  const std::vector<Vec3> standing = workshop.clay.surface().points;
  const Vec3 top = *std::max_element(standing.begin(), standing.end(),
                                     [](const Vec3& a, const Vec3& b) { return a.z() < b.z(); });
  const Vec3 there = about_x * (top - center);
  for (const Vec3& point : standing) ASSERT_GT((point - center - there).norm(), kBallRadius_m);
  workshop.frame(gpuHandAt(there));
  workshop.clay.rotate(about_x);
  EXPECT_EQ(workshop.frame(gpuHandAt(there)).touched, 0);
  EXPECT_EQ(workshop.frame(gpuHandAt(there)).touched, 0);
  EXPECT_GT(workshop.frame(gpuHandAt(there + Vec3(0.01, 0.07, 0))).touched, 0) << "that was a way into it";
}

}  // namespace
}  // namespace airclay
