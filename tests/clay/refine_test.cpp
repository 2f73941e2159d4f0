// SPDX-License-Identifier: MIT
// Refining compared with the surface that it must not change, and with Catmull-Clark's limit.
#include "engine/clay/refine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "engine/clay/presets.h"
#include "engine/mesh/manifold.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

constexpr SubdivisionRule kRules[] = {SubdivisionRule::kCatmullClark, SubdivisionRule::kPrinted};

/// Open: a fan of five triangles around a point, surrounded by a pentagon, a hexagon and a quad.
PolygonMesh openPolygons() {
  PolygonMesh mesh;
  mesh.points = {{0, 0, 0.3}};
  for (int i = 0; i < 5; ++i) {
    const double angle = 2 * std::numbers::pi * i / 5;
    mesh.points.emplace_back(std::cos(angle), std::sin(angle), 0.1 * i);
  }
  for (int i = 0; i < 5; ++i) mesh.faces.push_back({0, 1 + i, 1 + (i + 1) % 5});
  for (const Vec3& point : {Vec3(2, 0.2, 0.1), Vec3(2, 1.5, 0), Vec3(1.2, 2.2, 0.2), Vec3(0.3, 2, -0.1),
                            Vec3(-2, 1, 0), Vec3(-2.5, 0, 0.4), Vec3(-2, -1, 0.2)})
    mesh.points.push_back(point);
  mesh.faces.push_back({1, 6, 7, 8, 2});
  mesh.faces.push_back({2, 8, 9, 3});
  mesh.faces.push_back({3, 9, 10, 11, 12, 4});
  return mesh;
}

/// Closed: a heptagonal prism with a pyramid of seven triangles on top.
PolygonMesh closedPolygons() {
  PolygonMesh mesh;
  constexpr int around = 7;
  for (const double height : {0.0, 1.0})
    for (int i = 0; i < around; ++i) {
      const double angle = 2 * std::numbers::pi * i / around;
      mesh.points.emplace_back(std::cos(angle), std::sin(angle) * (1 + height), height + 0.05 * i);
    }
  mesh.points.emplace_back(0.1, 0.2, 2);
  std::vector<int> floor;
  for (int i = 0; i < around; ++i) {
    const int next = (i + 1) % around;
    mesh.faces.push_back({i, next, around + next, around + i});
    mesh.faces.push_back({around + i, around + next, 2 * around});
    floor.insert(floor.begin(), i);
  }
  mesh.faces.push_back(floor);
  return mesh;
}

std::vector<std::pair<std::string, PolygonMesh>> cages() {
  std::vector<std::pair<std::string, PolygonMesh>> all = {{"open polygons", openPolygons()},
                                                          {"closed polygons", closedPolygons()}};
  for (const std::string& name : presetNames()) all.emplace_back(name, presetCage(name));
  return all;
}

struct Surface {
  std::vector<Vec3> points;
  std::vector<std::array<int, 4>> quads;
};

Surface surfaceOf(const ClayState& state) {
  const Subdivision subdivision = subdivide(state.cage, state.levels, state.rule);
  return {dataPoints(subdivision.matrix, state.cage.points), subdivision.quads};
}

/// For each point of `from`, the index of the equal point of `to`, each once; -1 if none is within
/// `tolerance`.
std::vector<int> samePlaces(const std::vector<Vec3>& from, const std::vector<Vec3>& to, double tolerance) {
  std::vector<int> order(to.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  const auto x = [&](int i) { return to[static_cast<std::size_t>(i)].x(); };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return x(a) < x(b); });
  std::vector<int> found;
  std::set<int> taken;
  for (const Vec3& point : from) {
    auto at = std::lower_bound(order.begin(), order.end(), point.x() - tolerance,
                               [&](int i, double value) { return x(i) < value; });
    while (at != order.end() && x(*at) <= point.x() + tolerance &&
           ((to[static_cast<std::size_t>(*at)] - point).cwiseAbs().maxCoeff() > tolerance ||
            taken.count(*at) > 0))
      ++at;
    const bool here = at != order.end() && x(*at) <= point.x() + tolerance;
    found.push_back(here ? *at : -1);
    if (here) taken.insert(*at);
  }
  return found;
}

/// A quad that starts at its smallest corner, orientation unchanged.
std::array<int, 4> turned(std::array<int, 4> quad) {
  std::rotate(quad.begin(), std::min_element(quad.begin(), quad.end()), quad.end());
  return quad;
}

void expectSameSurface(const Surface& before, const Surface& after) {
  ASSERT_EQ(before.points.size(), after.points.size());
  ASSERT_EQ(before.quads.size(), after.quads.size());
  const std::vector<int> after_from_before = samePlaces(before.points, after.points, 1e-12);
  ASSERT_EQ(std::count(after_from_before.begin(), after_from_before.end(), -1), 0);
  std::set<std::array<int, 4>> expected, quads;
  for (std::array<int, 4> quad : before.quads) {
    for (int& corner : quad) corner = after_from_before[static_cast<std::size_t>(corner)];
    expected.insert(turned(quad));
  }
  for (const std::array<int, 4>& quad : after.quads) quads.insert(turned(quad));
  EXPECT_EQ(expected, quads);
}

TEST(Refine, KeepsTheSurface) {
  for (const auto& [name, cage] : cages())
    for (const SubdivisionRule rule : kRules)
      for (const int levels : {2, 3}) {
        SCOPED_TRACE(name + ", level " + std::to_string(levels));
        const ClayState before{cage, rule, levels, &kSolveTouched};
        const ClayState after = refine(before);
        EXPECT_NO_THROW(checkCage(after.cage, "refined"));
        EXPECT_EQ(after.levels, levels - 1);
        EXPECT_EQ(after.rule, rule);
        EXPECT_EQ(after.solve, &kSolveTouched);
        expectSameSurface(surfaceOf(before), surfaceOf(after));
      }
}

TEST(Refine, RefiningTwiceEqualsTwoMoreLevels) {
  const ClayState before{closedPolygons(), SubdivisionRule::kPrinted, 3, &kSolveAll};
  const ClayState after = refine(refine(before));
  EXPECT_EQ(after.levels, 1);
  expectSameSurface(surfaceOf(before), surfaceOf(after));
}

// V' = V + E + F: the paper's tube has 28 control points, 49 edges and 21 faces.
TEST(Refine, PaperTubeGets98ControlPoints) {
  const ClayState after = refine({presetCage("tube"), SubdivisionRule::kCatmullClark, 2, &kSolveAll});
  EXPECT_EQ(after.cage.points.size(), 98u);
  EXPECT_EQ(after.cage.faces.size(), 84u);
}

// At one level the surface equals two levels of the former cage.
TEST(Refine, AtLevelOneTheSurfaceIsOneStepFiner) {
  for (const SubdivisionRule rule : kRules) {
    const ClayState before{openPolygons(), rule, 1, &kSolveAll};
    const ClayState after = refine(before);
    EXPECT_EQ(after.levels, 1);
    ClayState finer = before;
    finer.levels = 2;
    expectSameSurface(surfaceOf(finer), surfaceOf(after));
  }
}

TEST(Refine, RejectsTooManyControlPoints) {
  ClayState state{presetCage("cube"), SubdivisionRule::kCatmullClark, 2, &kSolveAll};
  for (int i = 0; i < 4; ++i) state = refine(state);  // 26, 98, 386, 1538
  EXPECT_EQ(state.cage.points.size(), 1538u);
  const std::string message = messageOf([&] { refine(state); });  // 6146
  EXPECT_NE(message.find("refining turns 1538 control points into 6146; expected at most 4096"),
            std::string::npos)
      << message;
  EXPECT_NE(message.find("touched"), std::string::npos) << message;
  state.solve = &kSolveTouched;
  EXPECT_EQ(refine(state).cage.points.size(), 6146u);
}

}  // namespace
}  // namespace airclay
