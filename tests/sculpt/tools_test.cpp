// SPDX-License-Identifier: MIT
// The tools pull and smooth, and symmetry: their effect on the clay.
#include "engine/sculpt/tools.h"

#include <cmath>
#include <functional>
#include <iostream>

#include "engine/clay/presets.h"
#include "engine/sculpt/contact.h"
#include "engine/sculpt/grip.h"
#include "engine/sculpt/relax.h"
#include "engine/sculpt/sculptor.h"
#include "tests/support/contact_hands.h"
#include "tests/support/gpu_fixture.h"

namespace airclay {
namespace {

constexpr double kBallRadius_m = 0.03;
constexpr const SolveMethod* kBothSolves[] = {&kSolveAll, &kSolveTouched};

/// A ball of 10 cm about the origin: the preset, subdivided.
PolygonMesh ballCage(int levels) {
  const PolygonMesh cage = presetCage("ball");
  const Subdivision subdivision = subdivide(cage, levels, SubdivisionRule::kCatmullClark);
  PolygonMesh fine{dataPoints(subdivision.matrix, cage.points), {}};
  for (const std::array<int, 4>& quad : subdivision.quads) fine.faces.emplace_back(quad.begin(), quad.end());
  return fine;
}

/// A square sheet z = 0 about the origin, 0.2 m wide.
PolygonMesh sheetCage(int quads) {
  PolygonMesh cage;
  const auto at = [&](int i) { return 0.2 * i / quads - 0.1; };
  for (int y = 0; y <= quads; ++y)
    for (int x = 0; x <= quads; ++x) cage.points.emplace_back(at(x), at(y), 0);
  for (int y = 0; y < quads; ++y)
    for (int x = 0; x < quads; ++x) {
      const int corner = x + (quads + 1) * y;
      cage.faces.push_back({corner, corner + 1, corner + quads + 2, corner + quads + 1});
    }
  return cage;
}

/// Clay, hand and everything a frame needs.
struct Workshop {
  Workshop(const PolygonMesh& cage, const SolveMethod* rows, const HandModel& hand, int levels = 2)
      : grid(contactGrid(hand.skin)),
        clay(testGpu(), ClayState{cage, SubdivisionRule::kCatmullClark, levels, rows}, Vec3::Zero()),
        sculptor(testGpu(), clay, grid),
        fit(testGpu(), 1, Memory::kHost),
        recorder(testGpu()) {}

  ClayStep frame(const GpuHandPose& hand_fit, const SculptControls& controls) {
    fit.host()[0] = hand_fit;
    recorder.begin();
    sculptor.record(recorder, fit, controls);
    recorder.submitAndWait();
    EXPECT_TRUE(hazards(recorder.commands()).empty());
    if (sculptor.needsHost()) {
      sculptor.finishOnHost(recorder);
      EXPECT_TRUE(hazards(recorder.commands()).empty());
    }
    return sculptor.step();
  }
  std::vector<Vec3> surface() const { return clay.surface().points; }

  DistanceGrid grid;
  Clay clay;
  Sculptor sculptor;
  Buffer<GpuHandPose> fit;
  Recorder recorder;
};

double volume(const PolygonMesh& mesh) {
  double volume_m3 = 0;
  for (const std::vector<int>& face : mesh.faces)
    for (std::size_t k = 1; k + 1 < face.size(); ++k)
      volume_m3 += mesh.points[std::size_t(face[0])].dot(
                       mesh.points[std::size_t(face[k])].cross(mesh.points[std::size_t(face[k + 1])])) /
                   6;
  return volume_m3;
}

double largestMove(
    const std::vector<Vec3>& before, const std::vector<Vec3>& after,
    const std::function<bool(const Vec3&)>& which = [](const Vec3&) { return true; }) {
  double largest_m = 0;
  for (std::size_t i = 0; i < before.size(); ++i)
    if (which(before[i])) largest_m = std::max(largest_m, (after[i] - before[i]).norm());
  return largest_m;
}

/// The surface points within the grip's reach of a ball.
std::vector<std::size_t> within(const std::vector<Vec3>& points, const Vec3& center) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < points.size(); ++i)
    if ((points[i] - center).norm() <= kBallRadius_m + double(kGripReach_m)) found.push_back(i);
  return found;
}

SculptControls with(const Tool& tool, const Symmetry& symmetry = {}, bool held = true) {
  return {.tool = tool, .symmetry = symmetry, .held = held};
}

TEST(Tools, PullMovesOnlyTheGrippedPatch) {
  for (const SolveMethod* rows : kBothSolves) {
    Workshop workshop(ballCage(1), rows, ballHand(kBallRadius_m));
    const std::vector<Vec3> before = workshop.surface();
    const double edge = before[within(before, Vec3(0.12, 0, 0)).front()].norm();
    const Vec3 start(edge + kBallRadius_m + 0.002, 0.004, 0.001);
    const std::vector<std::size_t> held = within(before, start);
    ASSERT_GE(held.size(), 3u);
    EXPECT_EQ(workshop.frame(gpuHandAt(start), with(kPullTool)).touched, int(held.size()));
    EXPECT_EQ(largestMove(before, workshop.surface()), 0) << "taking hold moves nothing";
    // 3 cm away and slightly up, rotating by 0.3 rad
    for (int i = 1; i <= 15; ++i) {
      const Vec3 shift = i / 15.0 * Vec3(0.028, 0, 0.01);
      const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.02 * i, Vec3::UnitX()));
      const ClayStep step = workshop.frame(gpuHandAt(start + shift, turn), with(kPullTool));
      EXPECT_EQ(step.touched, int(held.size())) << "no more, no less";
      const std::vector<Vec3> now = workshop.surface();
      for (const std::size_t point : held)
        EXPECT_LT((now[point] - (start + shift + turn * (before[point] - start))).norm(), 0.001) << i;
    }
    EXPECT_LT(largestMove(before, workshop.surface(), [](const Vec3& p) { return p.x() < -0.03; }), 0.001);
  }
}

TEST(Tools, PullReleasesWithClutchToolOrHand) {
  const Vec3 start(0.13, 0, 0), away(0.16, 0, 0);
  const auto pulled = [&](const std::function<void(Workshop&)>& between) {
    Workshop workshop(ballCage(1), &kSolveAll, ballHand(kBallRadius_m));
    workshop.frame(gpuHandAt(start), with(kPullTool));
    workshop.frame(gpuHandAt(start + Vec3(0.002, 0, 0)), with(kPullTool));
    between(workshop);
    const std::vector<Vec3> before = workshop.surface();
    const int touched = workshop.frame(gpuHandAt(away), with(kPullTool)).touched;
    workshop.frame(gpuHandAt(away + Vec3(0.01, 0, 0)), with(kPullTool));
    return std::pair(touched, largestMove(before, workshop.surface()));
  };
  EXPECT_GT(pulled([](Workshop&) {}).second, 0.02) << "nothing let go";
  const GpuHandPose there = gpuHandAt(start + Vec3(0.004, 0, 0));
  for (const std::function<void(Workshop&)>& between : std::vector<std::function<void(Workshop&)>>{
           [&](Workshop& w) { w.frame(there, with(kPullTool, {}, false)); },
           [&](Workshop& w) { w.frame(there, with(kPushTool)); },
           [&](Workshop& w) { w.frame(there, with(kSmoothTool)); },
           [&](Workshop& w) { w.frame(lostHand(), with(kPullTool)); },
           [&](Workshop& w) { w.sculptor.forget(); }}) {
    const auto [touched, moved_m] = pulled(between);
    EXPECT_EQ(touched, 0) << "the hand is 3 cm off";
    EXPECT_EQ(moved_m, 0);
  }
}

TEST(Tools, PullGripsAtFirstTouch) {
  Workshop workshop(ballCage(1), &kSolveAll, ballHand(kBallRadius_m));
  const std::vector<Vec3> before = workshop.surface();
  EXPECT_EQ(workshop.frame(gpuHandAt(Vec3(0.2, 0, 0)), with(kPullTool)).touched, 0);
  EXPECT_EQ(workshop.frame(gpuHandAt(Vec3(0.16, 0, 0)), with(kPullTool)).touched, 0);
  const Vec3 touch(0.128, 0, 0);
  const int held = workshop.frame(gpuHandAt(touch), with(kPullTool)).touched;
  EXPECT_EQ(held, int(within(before, touch).size()));
  EXPECT_GT(held, 0);
  EXPECT_EQ(largestMove(before, workshop.surface()), 0);
  // it moves along the surface and gathers no further points
  for (int i = 1; i <= 5; ++i)
    EXPECT_EQ(workshop.frame(gpuHandAt(touch + Vec3(0, 0.004 * i, 0)), with(kPullTool)).touched, held);
  EXPECT_GT(largestMove(before, workshop.surface()), 0.018);
}

/// RMS distance from the best-fitting ball about the origin.
double roughness(const std::vector<Vec3>& points) {
  double mean = 0, square = 0;
  for (const Vec3& point : points) mean += point.norm() / double(points.size());
  for (const Vec3& point : points) square += std::pow(point.norm() - mean, 2) / double(points.size());
  return std::sqrt(square);
}

TEST(Tools, SmoothRemovesBumpsAndKeepsTheBall) {
  for (const SolveMethod* rows : kBothSolves) {
    PolygonMesh cage = ballCage(1);
    for (Vec3& point : cage.points) point *= 0.06 / point.norm();
    const PolygonMesh even = cage;
    // dents as wide as a fingertip: four control points per wave
    for (Vec3& point : cage.points)
      point *= 1 + 0.05 * std::sin(6 * std::atan2(point.y(), point.x())) *
                       std::sin(6 * std::acos(point.z() / point.norm()));
    for (const bool bumpy : {true, false}) {
      // a hand around the whole ball
      Workshop workshop(bumpy ? cage : even, rows, ballHand(0.07));
      const PolygonMesh before = workshop.clay.surface();
      workshop.frame(gpuHandAt(Vec3::Zero()), with(kSmoothTool));
      EXPECT_EQ(largestMove(before.points, workshop.surface()), 0) << "the first frame is the hand's coming";
      for (int i = 0; i < 30; ++i) {
        const ClayStep step = workshop.frame(gpuHandAt(Vec3::Zero()), with(kSmoothTool));
        EXPECT_LE(step.repeats, int(kRelaxRepeats));
        if (i == 0) {
          EXPECT_GT(step.touched, int(before.points.size()) * 9 / 10) << "the others' way is zero";
        }
      }
      const PolygonMesh after = workshop.clay.surface();
      std::cout << (bumpy ? "bumpy" : "even") << " ball: roughness " << 1000 * roughness(before.points)
                << " -> " << 1000 * roughness(after.points) << " mm, volume x "
                << volume(after) / volume(before) << '\n';
      EXPECT_NEAR(volume(after) / volume(before), 1, 0.02);
      if (bumpy) {
        EXPECT_LT(roughness(after.points), 0.5 * roughness(before.points));
      } else {
        EXPECT_LT(largestMove(before.points, after.points), 0.001);
      }
    }
  }
}

TEST(Tools, SmoothIsIndependentOfFrameRate) {
  PolygonMesh cage = ballCage(1);
  for (std::size_t i = 0; i < cage.points.size(); ++i)
    cage.points[i] *= (0.06 / cage.points[i].norm()) * (1 + 0.05 * std::sin(7.3 * double(i * i)));
  std::vector<std::vector<Vec3>> ends;
  double moved_m = 0;
  for (const int frames : {10, 40}) {
    Workshop workshop(cage, &kSolveAll, ballHand(0.07));
    const std::vector<Vec3> before = workshop.surface();
    SculptControls controls = with(kSmoothTool);
    controls.frame_s = 0.2 / frames;
    for (int i = 0; i <= frames; ++i) workshop.frame(gpuHandAt(Vec3::Zero()), controls);
    ends.push_back(workshop.surface());
    moved_m = largestMove(before, ends.back());
  }
  EXPECT_LT(largestMove(ends[0], ends[1]), 0.1 * moved_m);
}

TEST(Tools, SmoothStaysWithinReach) {
  Workshop workshop(sheetCage(16), &kSolveTouched, ballHand(kBallRadius_m));
  std::vector<Vec3> points = workshop.clay.cage().points;
  for (std::size_t i = 0; i < points.size(); ++i) points[i].z() += i % 2 == 0 ? 0.003 : -0.003;
  workshop.clay.setControlPoints(points);
  const std::vector<Vec3> before = workshop.surface();
  for (int i = 0; i < 10; ++i) workshop.frame(gpuHandAt(Vec3(0, 0, kBallRadius_m)), with(kSmoothTool));
  const std::vector<Vec3> after = workshop.surface();
  const auto off_axis = [](const Vec3& p) { return p.head<2>().norm(); };
  EXPECT_GT(largestMove(before, after, [&](const Vec3& p) { return off_axis(p) < 0.01; }), 0.0003);
  // three control points, a cage's stencil, beyond the reach
  EXPECT_EQ(largestMove(before, after, [&](const Vec3& p) { return off_axis(p) > 0.04 + 4 * 0.0125; }), 0);
}

TEST(Tools, SmoothKeepsFlatSheetAndRegularTube) {
  for (const SolveMethod* rows : kBothSolves) {
    Workshop sheet(sheetCage(8), rows, boxHand({0.3, 0.3, 0.01}));
    Workshop tube(presetCage("tube"), rows, boxHand({0.2, 0.2, 0.25}));
    const std::vector<Vec3> before = tube.surface();
    for (int i = 0; i < 30; ++i) {
      sheet.frame(gpuHandAt(Vec3::Zero()), with(kSmoothTool));
      tube.frame(gpuHandAt(Vec3::Zero()), with(kSmoothTool));
    }
    for (const Vec3& point : sheet.surface()) EXPECT_LT(std::abs(point.z()), 1e-9);
    EXPECT_LT(largestMove(before, tube.surface()), 0.0001);
  }
}

TEST(Tools, SmoothRelaxesADentedRimAsACurve) {
  for (const SolveMethod* rows : kBothSolves) {
    PolygonMesh cage = presetCage("tube");
    double top = 0;
    for (const Vec3& point : cage.points) top = std::max(top, point.z());
    bool up = false;
    for (Vec3& point : cage.points)
      if (point.z() > top - 1e-6) point.z() += (up = !up) ? 0.008 : -0.008;
    Workshop tube(cage, rows, boxHand({0.2, 0.2, 0.3}));
    const auto rimWave = [&] {
      // points on the rim belong to only one or two quads
      const SurfaceNeighbours neighbours =
          surfaceNeighbours(tube.clay.subdivision().quads, std::size_t(tube.clay.dataPointCount()));
      const std::vector<Vec3> points = tube.surface();
      double low = 1, high = -1;
      for (std::size_t i = 0; i < points.size(); ++i) {
        if (neighbours.borders[i] == 0 || points[i].z() < 0) continue;
        low = std::min(low, points[i].z());
        high = std::max(high, points[i].z());
      }
      return high - low;
    };
    const double before = rimWave();
    for (int i = 0; i < 30; ++i) tube.frame(gpuHandAt(Vec3::Zero()), with(kSmoothTool));
    EXPECT_GT(before, 0.004);
    EXPECT_LT(rimWave(), 0.5 * before);
  }
}

/// The distance of the surface from its mirror image, point to nearest point.
double asymmetry(const std::vector<Vec3>& points, const Vec3& signs) {
  double largest_m = 0;
  for (const Vec3& point : points) {
    double nearest_m = 1;
    for (const Vec3& other : points)
      nearest_m = std::min(nearest_m, (other - signs.cwiseProduct(point)).norm());
    largest_m = std::max(largest_m, nearest_m);
  }
  return largest_m;
}

TEST(Tools, EveryToolKeepsSymmetry) {
  const HandModel hand = ballHand(kBallRadius_m);
  for (const SolveMethod* rows : kBothSolves)
    for (const Tool* tool : tools())
      for (const Symmetry& symmetry : {Symmetry{true, false, false}, Symmetry{true, true, true}}) {
        PolygonMesh cage = presetCage("ball");
        for (Vec3& point : cage.points) point.x() *= 1.2;
        Workshop workshop(cage, rows, hand);
        const std::vector<Vec3> before = workshop.surface();
        for (int i = 0; i <= 12; ++i) {
          // over the side and across the planes of symmetry
          const double out = tool == &kPullTool ? 0.125 + 0.002 * i : 0.14 - 0.003 * i;
          workshop.frame(gpuHandAt(Vec3(0.03 - 0.005 * i, out, 0.01 - 0.002 * i)), with(*tool, symmetry));
        }
        const std::vector<Vec3> after = workshop.surface();
        EXPECT_GT(largestMove(before, after), tool == &kSmoothTool ? 0.00005 : 0.01);
        EXPECT_LT(asymmetry(after, Vec3(-1, 1, 1)), 1e-6);
        if (!symmetry.y) {
          EXPECT_GT(asymmetry(after, Vec3(1, -1, 1)), 1e-5) << "and in no other axis";
          continue;
        }
        EXPECT_LT(asymmetry(after, Vec3(1, -1, 1)), 1e-6);
        EXPECT_LT(asymmetry(after, Vec3(1, 1, -1)), 1e-6);
      }
}

TEST(Tools, SymmetryPlanesRotateWithTheClay) {
  // clay and hand rotated together give the same shape, rotated; the unrotated clay is the truth
  const HandModel hand = ballHand(kBallRadius_m);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));
  PolygonMesh cage = presetCage("ball");
  for (Vec3& point : cage.points) point.x() *= 1.2;
  const auto sculpt = [&](Workshop& workshop, const Eigen::Quaterniond& by, const Tool* tool) {
    for (int i = 0; i <= 12; ++i) {
      const double out = tool == &kPullTool ? 0.125 + 0.002 * i : 0.14 - 0.003 * i;
      const Vec3 place(0.03 - 0.001 * i, out, 0.01 - 0.002 * i);
      const Eigen::Quaterniond rotation(Eigen::AngleAxisd(0.02 * i, Vec3::UnitX()));
      workshop.frame(gpuHandAt(by * place, by * rotation), with(*tool, {true, true, false}));
    }
    std::vector<Vec3> surface = workshop.surface();
    for (Vec3& point : surface) point = by.conjugate() * point;
    return surface;
  };
  for (const SolveMethod* rows : kBothSolves)
    for (const Tool* tool : tools()) {
      Workshop lying(cage, rows, hand), turned(cage, rows, hand), moved(cage, rows, hand);
      const std::vector<Vec3> before = lying.surface();
      const std::vector<Vec3> truth = sculpt(lying, Eigen::Quaterniond::Identity(), tool);
      EXPECT_GT(largestMove(before, truth), tool == &kSmoothTool ? 0.00005 : 0.01);
      turned.clay.rotate(turn);
      const std::vector<Vec3> found = sculpt(turned, turn, tool);
      EXPECT_LT(largestMove(truth, found), 1e-5);
      EXPECT_LT(asymmetry(found, Vec3(-1, 1, 1)), 1e-6);
      EXPECT_LT(asymmetry(found, Vec3(1, -1, 1)), 1e-6);
      // points are not symmetric about the workspace's own planes
      std::vector<Vec3> points = cage.points;
      for (Vec3& point : points) point = turn * point;
      moved.clay.setControlPoints(points);
      EXPECT_GT(asymmetry(sculpt(moved, turn, tool), Vec3(1, -1, 1)), 2e-5);
    }
}

TEST(Tools, SymmetryEqualsAMirroredHandOnAnyMesh) {
  // an asymmetric cage: the mirrored stroke equals that of a mirrored hand
  PolygonMesh cage = ballCage(1);
  for (std::size_t i = 0; i < cage.points.size(); ++i) cage.points[i] *= 1 + 0.02 * std::sin(double(i * i));
  const HandModel hand = ballHand(kBallRadius_m);
  for (const Tool* tool : {&kPushTool, &kPullTool}) {
    std::vector<std::vector<Vec3>> surfaces;
    for (const double side : {1.0, -1.0, 0.0}) {  // 0: both, by symmetry
      Workshop workshop(cage, &kSolveTouched, hand);
      for (int i = 0; i <= 8; ++i) {
        const double out = tool == &kPullTool ? 0.125 + 0.002 * i : 0.14 - 0.003 * i;
        workshop.frame(gpuHandAt(Vec3(side < 0 ? -out : out, 0.01, 0)),
                       with(*tool, {side == 0, false, false}));
      }
      surfaces.push_back(workshop.surface());
    }
    const std::vector<Vec3> before =
        dataPoints(subdivide(cage, 2, SubdivisionRule::kCatmullClark).matrix, cage.points);
    const auto right = [](const Vec3& p) { return p.x() > 0.05; };
    const auto left = [](const Vec3& p) { return p.x() < -0.05; };
    EXPECT_GT(largestMove(before, surfaces[2], right), 0.008);
    EXPECT_GT(largestMove(before, surfaces[2], left), 0.008);
    // the rows of the two strokes are far apart, so each acts as if alone, except for when repeats end
    EXPECT_LT(largestMove(surfaces[0], surfaces[2], right), 0.0015);
    EXPECT_LT(largestMove(surfaces[1], surfaces[2], left), 0.0015);
  }
}

TEST(Tools, SwitchingToolsDoesNotJump) {
  for (const SolveMethod* rows : kBothSolves) {
    Workshop workshop(ballCage(1), rows, ballHand(kBallRadius_m));
    // the hand stays half inside the clay: no switch moves anything except smoothing, which does little per
    // frame
    const GpuHandPose still = gpuHandAt(Vec3(0.11, 0, 0));
    workshop.frame(still, with(kPushTool));
    const std::vector<Vec3> before = workshop.surface();
    for (int i = 0; i < 3; ++i)
      for (const Tool* tool : {&kPullTool, &kPushTool, &kPullTool})
        for (const Symmetry& symmetry :
             {Symmetry{}, Symmetry{true, true, true}, Symmetry{false, true, false}}) {
          workshop.frame(still, with(*tool, symmetry));
          workshop.frame(still, with(*tool, symmetry));
        }
    EXPECT_LT(largestMove(before, workshop.surface()), 1e-5);
    workshop.frame(still, with(kSmoothTool));
    workshop.frame(still, with(kSmoothTool));
    EXPECT_LT(largestMove(before, workshop.surface()), 0.0005);
  }
}

TEST(Tools, SymmetricHandsPullAnOpenSheet) {
  for (const SolveMethod* rows : kBothSolves) {
    Workshop workshop(sheetCage(12), rows, ballHand(kBallRadius_m));
    const std::vector<Vec3> before = workshop.surface();
    for (int i = 0; i <= 10; ++i)
      workshop.frame(gpuHandAt(Vec3(0.06, 0, 0.032 + 0.002 * i)), with(kPullTool, {true, false, false}));
    const std::vector<Vec3> after = workshop.surface();
    EXPECT_LT(asymmetry(after, Vec3(-1, 1, 1)), 1e-6);
    double right = 0, left = 0;
    for (const Vec3& point : after) {
      if ((point - Vec3(0.06, 0, 0)).head<2>().norm() < 0.005) right = std::max(right, point.z());
      if ((point - Vec3(-0.06, 0, 0)).head<2>().norm() < 0.005) left = std::max(left, point.z());
    }
    EXPECT_NEAR(right, 0.02, 0.001);
    EXPECT_NEAR(left, 0.02, 0.001);
  }
}

}  // namespace
}  // namespace airclay
