// SPDX-License-Identifier: MIT
// The kernels of pull and smooth compared with their references, and the neighbours that smoothing uses.
#include <algorithm>
#include <cmath>
#include <random>

#include "engine/clay/presets.h"
#include "engine/sculpt/grip.h"
#include "engine/sculpt/relax.h"
#include "tests/support/contact_hands.h"
#include "tests/support/gpu_fixture.h"

namespace airclay {
namespace {

ContactPose poseOf(const GpuHandPose& fit) {
  return {Eigen::Quaterniond(Eigen::Vector4d(fit.rotation.cast<double>())), fit.position.cast<double>()};
}

GpuHandPose turnedFit(double angle, const Vec3& position) {
  return gpuHandAt(position, Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vec3(1, 2, -1).normalized())));
}

std::vector<Vec3> scattered(int count, double radius_m) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-radius_m, radius_m);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const vec3 rounded = Vec3(uniform(random), uniform(random), uniform(random)).cast<float>();
    points.push_back(rounded.cast<double>());
  }
  return points;
}

std::vector<vec3> floats(const std::vector<Vec3>& points) {
  std::vector<vec3> rounded;
  for (const Vec3& point : points) rounded.push_back(point.cast<float>());
  return rounded;
}

TEST(Grip, EqualsTheReference) {
  const DistanceGrid grid = contactGrid(builtInHand(false).skin);
  const std::vector<Vec3> start = scattered(3000, 0.1);
  const std::vector<Vec3> shifts = scattered(3000, 0.003);
  for (const Symmetry& symmetry : {Symmetry{}, Symmetry{true, false, false}, Symmetry{true, true, true}}) {
    const std::uint32_t mirrors = mirrorsOf(symmetry);
    ContactFrame frame(testGpu(), grid, 3000);
    frame.setMirrors(mirrors);
    Grip grip(testGpu(), frame);
    Buffer<vec3> data_points(testGpu(), floats(start), Memory::kHost);
    Buffer<GpuHandPose> fit(testGpu(), 1, Memory::kHost);
    Recorder recorder(testGpu());
    const auto check = [&](const GpuHandPose& hand) {
      fit.host()[0] = hand;
      recorder.begin();
      frame.recordBegin(recorder, fit, true);
      grip.recordCheck(recorder, data_points, true);
      recorder.submitAndWait();
      EXPECT_TRUE(hazards(recorder.commands()).empty());
      return grip.points();
    };
    const GpuHandPose before = turnedFit(0.4, Vec3(0.02, 0.01, 0.03)),
                      now = turnedFit(0.7, Vec3(0.03, 0, 0.01));
    const std::vector<GpuGripPoint> held = check(before);
    int differ = 0, count = 0;
    for (std::size_t i = 0; i < start.size(); ++i) {
      differ += held[i].images != gripReference(grid, poseOf(before), mirrors, start[i]);
      count += held[i].images != 0;
    }
    EXPECT_EQ(int(frame.summary().touched), count);
    EXPECT_GT(count, 100);
    EXPECT_LT(count, 2900);
    EXPECT_LE(differ, 3) << "within rounding of the reach";

    std::vector<Vec3> moved = start;
    for (std::size_t i = 0; i < moved.size(); ++i) moved[i] += shifts[i];
    data_points.upload(floats(moved));
    const std::vector<GpuGripPoint> lagging = check(now);
    double error = 0, largest = 0;
    for (std::size_t i = 0; i < start.size(); ++i) {
      if (held[i].images == 0) continue;
      const Vec3 lag = gripTarget(poseOf(before), poseOf(now), mirrors, held[i].images, start[i]) - moved[i];
      error = std::max(error, (lagging[i].lag.cast<double>() - lag).norm());
      largest = std::max(largest, lag.norm());
    }
    EXPECT_LT(error, 1e-6);
    EXPECT_NEAR(frame.summary().depth_m, largest, 1e-6);
  }
}

TEST(Relax, EqualsTheReference) {
  const HandModel hand = builtInHand(false);
  const DistanceGrid grid = contactGrid(hand.skin);
  for (const std::string preset : {"tube", "ball"})  // with borders and without
    for (const Symmetry& symmetry : {Symmetry{}, Symmetry{true, true, false}}) {
      PolygonMesh cage = presetCage(preset);
      for (std::size_t i = 0; i < cage.points.size(); ++i)
        cage.points[i] *= 1 + 0.1 * std::sin(double(i * i));
      const Subdivision subdivision = subdivide(cage, 2, SubdivisionRule::kCatmullClark);
      const std::vector<Vec3> points = dataPoints(subdivision.matrix, cage.points);
      const std::vector<Vec3> normals = dataNormals(subdivision.quads, points);
      const auto count = static_cast<std::uint32_t>(points.size());
      ContactFrame frame(testGpu(), grid, count);
      frame.setMirrors(mirrorsOf(symmetry));
      Relaxer relaxer(testGpu(), frame, subdivision);
      const Buffer<vec3> data_points(testGpu(), floats(points)), data_normals(testGpu(), floats(normals));
      Buffer<GpuHandPose> fit(testGpu(), 1, Memory::kHost);
      fit.host()[0] = turnedFit(0.3, Vec3(0.05, 0.02, 0.01));
      Recorder recorder(testGpu());
      for (int i = 0; i < 2; ++i) {  // the first one only tells where the hand is
        recorder.begin();
        frame.recordBegin(recorder, fit, true);
        relaxer.record(recorder, data_points, data_normals, 20);
        recorder.submitAndWait();
        EXPECT_TRUE(hazards(recorder.commands()).empty());
      }
      std::vector<double> nearness;
      for (const Vec3& point : points)
        nearness.push_back(relaxNearness(grid, poseOf(fit.host()[0]), mirrorsOf(symmetry), point));
      const std::vector<Vec3> expected =
          relaxReference(surfaceNeighbours(subdivision.quads, count), points, normals, nearness, 20);
      const std::vector<vec3> found = frame.displacements().download();
      double largest = 0, error = 0;
      int touched = 0;
      for (std::size_t i = 0; i < found.size(); ++i) {
        largest = std::max(largest, expected[i].norm());
        error = std::max(error, (found[i].cast<double>() - expected[i]).norm());
        touched += nearness[i] > 0;
      }
      EXPECT_GT(touched, 10);
      EXPECT_LT(touched, int(count));
      EXPECT_GT(largest, 0.001);
      EXPECT_LT(error, 1e-4 * largest);
      EXPECT_EQ(frame.summary().done, 0u) << "there is something to do";
    }
}

TEST(Relax, NeighboursShareAnEdge) {
  // a sheet of 2 x 2 quads: points 0 1 2 / 3 4 5 / 6 7 8
  const std::vector<std::array<int, 4>> quads = {{0, 1, 4, 3}, {1, 2, 5, 4}, {3, 4, 7, 6}, {4, 5, 8, 7}};
  const SurfaceNeighbours neighbours = surfaceNeighbours(quads, 9);
  const auto around = [&](std::size_t point) {
    std::vector<std::uint32_t> found(neighbours.entries.begin() + neighbours.starts[point],
                                     neighbours.entries.begin() + neighbours.starts[point + 1]);
    std::sort(found.begin(), found.end());
    return found;
  };
  using Points = std::vector<std::uint32_t>;
  EXPECT_EQ(around(4), (Points{1, 3, 5, 7}));
  EXPECT_EQ(around(0), (Points{1, 3}));
  EXPECT_EQ(around(1), (Points{0, 2}));
  EXPECT_EQ(around(5), (Points{2, 8}));
  for (std::size_t point = 0; point < 9; ++point) EXPECT_EQ(neighbours.borders[point], point == 4 ? 0u : 1u);
  // a closed surface has no border
  const Subdivision ball = subdivide(presetCage("ball"), 1, SubdivisionRule::kCatmullClark);
  const SurfaceNeighbours closed = surfaceNeighbours(ball.quads, std::size_t(ball.matrix.rows()));
  EXPECT_EQ(std::count(closed.borders.begin(), closed.borders.end(), 1u), 0);
  EXPECT_EQ(closed.entries.size(), 4 * ball.quads.size()) << "each edge from both ends";
}

TEST(Relax, StrengthGrowsWithTimeUpToTheLimit) {
  for (const int levels : {1, 2, 3, 4}) {
    const double roughest = 1 - std::cos(M_PI / std::exp2(levels));
    const double all = 1 / (roughest * roughest);
    EXPECT_EQ(relaxStrength(levels, 0), 0);
    EXPECT_NEAR(relaxStrength(levels, 1e-6) / all, 1e-6 / (kRelaxRepeats * kRelaxTime_s), 1e-8);
    EXPECT_LE(relaxStrength(levels, 100), all);
    // the remainder after two steps equals the remainder after one step of twice the duration
    const double left = 1 - relaxStrength(levels, 0.01) / all;
    EXPECT_NEAR(left * left, 1 - relaxStrength(levels, 0.02) / all, 1e-12);
  }
}

}  // namespace
}  // namespace airclay
