// SPDX-License-Identifier: MIT
// Remeshed solids compared with their closed forms.
#include "engine/clay/remesh.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <cmath>
#include <numbers>

#include "engine/clay/presets.h"
#include "engine/core/task.h"
#include "engine/mesh/lattice_crossings.h"
#include "engine/mesh/manifold.h"
#include "engine/mesh/mesh_export.h"
#include "tests/support/solids.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

constexpr double kPi = std::numbers::pi;

TriangleMesh trianglesOf(const PolygonMesh& mesh) {
  return {mesh.points, triangulated(mesh)};
}

/// The surface as a document shows it.
PolygonMesh surfaceAt2(const PolygonMesh& cage) {
  return meshAtLevel(cage, 2, SubdivisionRule::kCatmullClark);
}

/// A closed 2-manifold of quads with this Euler characteristic, without degenerate quads, outwards.
void expectGoodCage(const Remeshing& result, int euler) {
  EXPECT_NO_THROW(checkCage(result.cage, "cage"));
  EXPECT_EQ(openEdges(trianglesOf(result.cage)), 0u);
  EXPECT_EQ(eulerCharacteristic(result.cage), euler);
  EXPECT_GT(massProperties(trianglesOf(result.cage)).volume_m3, 0);
  double shortest = 1e300, longest = 0;
  for (const std::vector<int>& face : result.cage.faces) {
    ASSERT_EQ(face.size(), 4u);
    for (std::size_t k = 0; k < 4; ++k) {
      const double edge = (result.cage.points[face[k]] - result.cage.points[face[(k + 1) % 4]]).norm();
      shortest = std::min(shortest, edge);
      longest = std::max(longest, edge);
    }
  }
  EXPECT_GT(shortest, 0.1 * result.edge_m);
  EXPECT_LT(longest, 3 * result.edge_m);
}

/// Distance to the closed form within a quarter of an edge at every point of the surface, and the volume
/// within half a percent.
void expectNear(const Remeshing& result, const std::function<double(const Vec3&)>& distance, double volume) {
  const PolygonMesh surface = surfaceAt2(result.cage);
  double farthest = 0;
  for (const Vec3& point : surface.points) farthest = std::max(farthest, std::abs(distance(point)));
  EXPECT_LE(farthest, result.edge_m / 4);
  EXPECT_LE(result.hausdorff_m, result.edge_m / 4);
  EXPECT_NEAR(massProperties(trianglesOf(surface)).volume_m3 / volume, 1, 0.005);
  EXPECT_NEAR(result.volume_m3 / volume, 1, 0.005);
  EXPECT_LT(std::abs(result.volumeChangePercent()), 0.5);
}

TEST(Remesh, BallOfAbout1600Faces) {
  const double radius = 0.05;
  const Remeshing result = remesh(ballMesh(Vec3(0.3, -0.1, 0.2), radius, 6), {});
  EXPECT_NEAR(double(result.cage.faces.size()), 1600, 48);
  expectGoodCage(result, 2);
  expectNear(
      result, [&](const Vec3& p) { return (p - Vec3(0.3, -0.1, 0.2)).norm() - radius; },
      4 * kPi / 3 * std::pow(radius, 3));
}

TEST(Remesh, TorusWithGivenEdge) {
  const double major = 0.06, minor = 0.02, edge = 0.006;
  RemeshOptions options;
  options.edge_m = edge;
  const Remeshing result = remesh(torusMesh(major, minor, 200, 80), options);
  EXPECT_NEAR(result.edge_m / edge, 1, 0.03);
  expectGoodCage(result, 0);
  expectNear(
      result, [&](const Vec3& p) { return std::hypot(std::hypot(p.x(), p.y()) - major, p.z()) - minor; },
      2 * kPi * kPi * major * minor * minor);
}

TEST(Remesh, OverlappingBallsFuse) {
  const double radius = 0.05, apart = 0.06;
  const Vec3 other(0, apart, 0);
  const TriangleMesh both = together(ballMesh(Vec3::Zero(), radius, 6), ballMesh(other, radius, 6));
  const Remeshing result = remesh(both, {});
  expectGoodCage(result, 2);
  const double lens = kPi * (4 * radius + apart) * std::pow(2 * radius - apart, 2) / 12;
  const double crease_radius = std::sqrt(radius * radius - apart * apart / 4);
  expectNear(
      result,
      [&](const Vec3& p) {
        const double inside = std::min(p.norm(), (p - other).norm()) - radius;
        if (inside >= 0) return inside;
        // Inside the union, its nearest point may be on the crease.
        const double to_crease = std::hypot(std::hypot(p.x(), p.z()) - crease_radius, p.y() - apart / 2);
        const Vec3 center = p.y() < apart / 2 ? Vec3(Vec3::Zero()) : other;
        return std::min(radius - (p - center).norm(), to_crease);
      },
      2 * 4 * kPi / 3 * std::pow(radius, 3) - lens);
  EXPECT_NEAR(result.input_volume_m3 / (2 * 4 * kPi / 3 * std::pow(radius, 3) - lens), 1, 0.001);
}

TEST(Remesh, SeparateBallsStaySeparate) {
  const double radius = 0.05, gap = 0.001;  // a fifth of an edge
  const TriangleMesh both =
      together(ballMesh(Vec3::Zero(), radius, 6), ballMesh(Vec3(2 * radius + gap, 0, 0), radius, 6));
  const Remeshing result = remesh(both, {});
  EXPECT_GT(result.edge_m, 3 * gap);
  expectGoodCage(result, 4);
  expectNear(
      result,
      [&](const Vec3& p) { return std::min(p.norm(), (p - Vec3(2 * radius + gap, 0, 0)).norm()) - radius; },
      2 * 4 * kPi / 3 * std::pow(radius, 3));
}

TEST(Remesh, HollowBallKeepsItsCavity) {
  const double outer = 0.05, inner = 0.025;
  TriangleMesh cavity = ballMesh(Vec3::Zero(), inner, 5);
  for (auto& triangle : cavity.triangles) std::swap(triangle[0], triangle[1]);
  const Remeshing result = remesh(together(ballMesh(Vec3::Zero(), outer, 6), cavity), {});
  expectGoodCage(result, 4);
  expectNear(
      result, [&](const Vec3& p) { return std::min(std::abs(p.norm() - outer), std::abs(p.norm() - inner)); },
      4 * kPi / 3 * (std::pow(outer, 3) - std::pow(inner, 3)));
}

// One closed surface that crosses itself: the tube around a figure of eight, whose union has two holes.
TEST(Remesh, SelfOverlappingLobesFuse) {
  const double scale = 0.06, radius = 0.012;
  const Remeshing result = remesh(figureEightMesh(scale, radius, 400, 60), {});
  expectGoodCage(result, -2);
  double farthest = 0;
  for (const Vec3& p : surfaceAt2(result.cage).points) {
    double nearest = 1e300;
    for (int i = 0; i < 4000; ++i)
      nearest = std::min(nearest, (p - figureEightCurve(scale, 2 * kPi * i / 4000)).squaredNorm());
    farthest = std::max(farthest, std::abs(std::sqrt(nearest) - radius));
  }
  EXPECT_LE(farthest, result.edge_m / 4);
  EXPECT_LE(result.hausdorff_m, result.edge_m / 4);
  EXPECT_LT(std::abs(result.volumeChangePercent()), 0.5);
}

TEST(Remesh, CubeKeepsItsEdges) {
  const double half = 0.05;
  const Remeshing result = remesh(boxMesh(Vec3::Constant(half)), {});
  expectGoodCage(result, 2);
  RecordProperty("hausdorff_in_edges", std::to_string(result.hausdorff_m / result.edge_m));
  expectNear(
      result,
      [&](const Vec3& p) {
        const Vec3 beyond = p.cwiseAbs() - Vec3::Constant(half);
        return beyond.cwiseMax(Vec3::Zero()).norm() + std::min(beyond.maxCoeff(), 0.);
      },
      8 * half * half * half);
}

TEST(Remesh, OpenTubeNeedsAThickness) {
  TriangleMesh tube = torusMesh(1, 1, 96, 24);  // only its connectivity: opened at one place
  const double radius = 0.05, length = 0.12, thickness = 0.02;
  for (int u = 0; u < 96; ++u)
    for (int v = 0; v < 24; ++v) {
      const double around = 2 * kPi * u / 96;
      tube.vertices[std::size_t(u * 24 + v)] =
          Vec3(radius * std::cos(around), radius * std::sin(around), length * v / 23);
    }
  std::erase_if(tube.triangles, [](const std::array<int, 3>& t) {
    const auto [low, high] = std::minmax({t[0] % 24, t[1] % 24, t[2] % 24});
    return high - low > 1;
  });
  const std::string message = messageOf([&] { remesh(tube, {}); });
  EXPECT_NE(message.find("open at 192 edges"), std::string::npos) << message;
  EXPECT_NE(message.find("--thicken"), std::string::npos) << message;
  RemeshOptions options;
  options.thicken_m = thickness;
  options.edge_m = thickness / 2;
  const Remeshing result = remesh(tube, options);
  expectGoodCage(result, 0);
  expectNear(
      result,
      [&](const Vec3& p) {
        const double across = std::abs(std::hypot(p.x(), p.y()) - radius) - thickness / 2;
        const double along = std::abs(p.z() - length / 2) - length / 2;
        return std::hypot(std::max(across, 0.), std::max(along, 0.)) + std::min(std::max(across, along), 0.);
      },
      2 * kPi * radius * thickness * length);
  options.edge_m = thickness;
  EXPECT_NE(messageOf([&] { remesh(tube, options); }).find("use --edge-mm 10 or --thicken 40"),
            std::string::npos)
      << messageOf([&] { remesh(tube, options); });
}

TEST(Remesh, PresetsKeepTheirSurface) {
  for (const std::string& name : presetNames()) {
    if (name == "tube") continue;  // open
    SCOPED_TRACE(name);
    const RemeshOptions options;
    const TriangleMesh surface = fineSurface(presetCage(name), SubdivisionRule::kCatmullClark, options);
    const Remeshing result = remesh(surface, options);
    expectGoodCage(result, 2);
    EXPECT_LE(result.hausdorff_m, result.edge_m / 4);
    EXPECT_NEAR(result.volume_m3 / massProperties(surface).volume_m3, 1, 0.005);
  }
}

/// Restricts this thread, and those that it starts, to one core while it exists.
class OneCore {
 public:
  OneCore() {
    EXPECT_EQ(sched_getaffinity(0, sizeof before_, &before_), 0);
    cpu_set_t one;
    CPU_ZERO(&one);
    for (int cpu = 0; cpu < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++cpu)
      if (CPU_ISSET(cpu, &before_)) CPU_SET(cpu, &one);
    EXPECT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  }
  ~OneCore() { EXPECT_EQ(sched_setaffinity(0, sizeof before_, &before_), 0); }
  OneCore(const OneCore&) = delete;
  OneCore& operator=(const OneCore&) = delete;

 private:
  cpu_set_t before_;
};

TEST(Remesh, ResultDoesNotDependOnCores) {
  const TriangleMesh both = together(ballMesh(Vec3::Zero(), 0.05, 4), ballMesh(Vec3(0.06, 0.01, 0), 0.04, 4));
  const Remeshing all = remesh(both, {});
  const Remeshing alone = [&] {
    const OneCore core;
    return remesh(both, {});
  }();
  EXPECT_EQ(all.cage.faces, alone.cage.faces);
  EXPECT_EQ(all.cage.points, alone.cage.points);
  EXPECT_EQ(all.hausdorff_m, alone.hausdorff_m);
  EXPECT_EQ(all.volume_m3, alone.volume_m3);
}

struct Stop {};

/// Cancels at the report with this number.
struct StopAt : Task {
  explicit StopAt(int report) : left(report) {}
  void onProgress(double) override {
    if (left-- == 0) throw Stop{};
  }
  int left;
};

TEST(Remesh, CanBeCancelledThroughout) {
  const OneCore core;  // otherwise the number of reports depends on how the threads share the work
  const TriangleMesh ball = ballMesh(Vec3::Zero(), 0.05, 4);
  constexpr int kNever = 1'000'000'000;
  int reports = 0;
  {
    const StopAt never(kNever);
    remesh(ball, {});
    reports = kNever - never.left;
  }
  EXPECT_GT(reports, 50);
  {
    const StopAt never(kNever);
    remesh(ball, {});
    EXPECT_EQ(reports, kNever - never.left);
  }
  for (const int report : {0, 1, reports / 4, reports / 2, 3 * reports / 4, reports - 1}) {
    const StopAt stop(report);
    EXPECT_THROW(remesh(ball, {}), Stop) << report;
  }
}

TEST(Remesh, RefusesWhatDoesNotFit) {
  const TriangleMesh ball = ballMesh(Vec3::Zero(), 0.05, 3);
  const auto messageFor = [&](const RemeshOptions& options) {
    return messageOf([&] { remesh(ball, options); });
  };
  RemeshOptions options;
  options.faces = 10;
  EXPECT_NE(messageFor(options).find("expected 50 to 100000"), std::string::npos) << messageFor(options);
  for (const double edge : {0.00001, 0.05}) {
    options.edge_m = edge;
    EXPECT_NE(messageFor(options).find("expected --edge-mm from "), std::string::npos) << messageFor(options);
  }
  options = {};
  options.thicken_m = 0.01;
  EXPECT_NE(messageFor(options).find("the surface is closed"), std::string::npos) << messageFor(options);
  EXPECT_NE(messageOf([] { remesh(TriangleMesh{}, {}); }).find("no faces"), std::string::npos);
  TriangleMesh inverted = ball;
  for (auto& triangle : inverted.triangles) std::swap(triangle[0], triangle[1]);
  EXPECT_NE(messageOf([&] { remesh(inverted, {}); }).find("encloses no volume"), std::string::npos);
}

TEST(Remesh, StateKeepsRuleSolveAndRotation) {
  ClayState state{presetCage("ball"), SubdivisionRule::kPrinted, 4, &kSolveTouched};
  state.workspace_from_clay = Eigen::AngleAxisd(0.5, Vec3::UnitX());
  const ClayState remeshed = remesh(state, remeshFaces(state));
  EXPECT_NO_THROW(checkClayState(remeshed, "remeshed"));
  EXPECT_NEAR(double(remeshed.cage.faces.size()), 1600, 48);
  EXPECT_EQ(remeshed.rule, SubdivisionRule::kPrinted);
  EXPECT_EQ(remeshed.solve, &kSolveTouched);
  EXPECT_EQ(remeshed.levels, 1);
  EXPECT_EQ(remeshed.workspace_from_clay.coeffs(), state.workspace_from_clay.coeffs());
  const auto volume = [](const ClayState& s) {
    return massProperties(trianglesOf(meshAtLevel(s.cage, 4, s.rule))).volume_m3;
  };
  EXPECT_NEAR(volume(remeshed) / volume(state), 1, 0.005);
  state.solve = &kSolveAll;
  EXPECT_NE(messageOf([&] { remesh(state, 6000); }).find("expected at most 4096 for this solve"),
            std::string::npos);
}

}  // namespace
}  // namespace airclay
