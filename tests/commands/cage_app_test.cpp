// SPDX-License-Identifier: MIT
// Commands that are given a cage's file: notes, units and axes, and what `airclay check` reports.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "engine/clay/document.h"
#include "engine/mesh/mesh_file.h"
#include "tests/support/cage_files.h"
#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

using nlohmann::json;

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// Six quads that share no vertices.
PolygonMesh separateQuads(double size) {
  const PolygonMesh cube = cubeCage(size);
  PolygonMesh separate;
  for (const std::vector<int>& face : cube.faces) {
    separate.faces.emplace_back();
    for (const int corner : face) {
      separate.faces.back().push_back(int(separate.points.size()));
      separate.points.push_back(cube.points[std::size_t(corner)]);
    }
  }
  return separate;
}

struct CageApp : ::testing::Test {
  TemporaryFolder folder;
  std::string at(const std::string& name) const { return (folder / name).string(); }
  std::string put(const std::string& name, const std::string& content) const {
    return folder.write(name, content).string();
  }
};

TEST_F(CageApp, EveryFormatBecomesClay) {
  for (const auto& [name, content] : cageFiles(cubeCage(0.2))) {
    const RunResult result = runAirclay({"export", put("my cage #1 " + name, content), "--units", "m", "--up",
                                         "z", "--what", "cage", "--json", "--out", at("out.obj")});
    ASSERT_EQ(result.status, 0) << name << result.errors;
    EXPECT_NEAR(json::parse(result.output)["volume_cm3"], 8000, 0.01) << name;
  }
}

TEST_F(CageApp, PrintsEachNoteOnce) {
  const std::string file = put("quads.obj", objOf(separateQuads(200)));
  const RunResult result = runAirclay({"export", file, "--what", "cage", "--out", at("out.obj")});
  EXPECT_EQ(result.status, 0);
  const std::vector<std::string> lines = result.errorLines();
  ASSERT_EQ(lines.size(), 2u) << result.errors;
  EXPECT_TRUE(contains(lines[0], "quads.obj: welded 16 vertices")) << lines[0];
  EXPECT_TRUE(contains(lines[1], "quads.obj: its longest side is 200 m")) << lines[1];
  EXPECT_TRUE(contains(lines[1], "--units mm")) << lines[1];
}

TEST_F(CageApp, UnitsAndUpAxisReachTheClay) {
  PolygonMesh slab = cubeCage(8);
  for (Vec3& point : slab.points) point.y() /= 4;
  const std::string file = put("slab.obj", objOf(slab));
  const std::vector<std::vector<std::string>> commands = {
      {"export", file, "--what", "cage", "--out", at("cage.obj")},
      {"subdivide", file, "--levels", "1", "--out", at("surface.obj")},
      {"new", at("new.clay"), "--clay", file},
      {"set", at("old.clay"), "--clay", file}};
  ASSERT_EQ(runAirclay({"new", at("old.clay")}).status, 0);
  for (std::vector<std::string> command : commands) {
    command.insert(command.end(), {"--units", "in", "--up", "y"});
    const RunResult result = runAirclay(command);
    EXPECT_EQ(result.status, 0) << result.errors;
    EXPECT_EQ(result.errors, "") << command[0];
  }
  for (const PolygonMesh& cage : {readObj(at("cage.obj")), Document::open(at("new.clay")).state().cage,
                                  Document::open(at("old.clay")).state().cage}) {
    Eigen::AlignedBox3d box;
    for (const Vec3& point : cage.points) box.extend(point);
    EXPECT_LT((box.sizes() - Vec3(0.2032, 0.2032, 0.0508)).norm(), 1e-8);
  }
}

TEST_F(CageApp, RefusesInOneLine) {
  const std::string fin =
      put("fin.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 2 1 4\nf 1 2 5\n");
  ASSERT_EQ(runAirclay({"new", at("a.clay")}).status, 0);
  const std::vector<std::tuple<std::vector<std::string>, int, std::string>> cases = {
      {{"export", fin, "--out", at("b.obj")}, 1, "more than two faces"},
      {{"export", put("cage.fbx", "x"), "--out", at("b.obj")}, 2, "expected .obj, .ply, .stl, .gltf or .glb"},
      {{"export", "cube", "--units", "mm", "--out", at("b.obj")}, 2, "cube is a preset"},
      {{"export", at("a.clay"), "--up", "y", "--out", at("b.obj")}, 2, "--up applies to a cage's file"},
      {{"export", fin, "--units", "ft", "--out", at("b.obj")}, 2, "--units"},
      {{"set", at("a.clay"), "--levels", "1", "--units", "mm"}, 2, "--clay names one"},
      {{"check", at("a.toml"), "--units", "cm"}, 2, "--units cm applies to a cage's file"},
      {{"check", at("a.toml"), "--up", "y"}, 2, "--up applies to a cage's file"},
  };
  for (const auto& [arguments, status, expected] : cases) {
    const RunResult result = runAirclay(arguments);
    EXPECT_EQ(result.status, status) << result.errors;
    EXPECT_EQ(result.errorLines().size(), 1u) << result.errors;
    EXPECT_TRUE(contains(result.errors, expected)) << result.errors;
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "b.obj"));
}

TEST_F(CageApp, CheckReportsACage) {
  std::string obj = objOf(separateQuads(200)) + "v 9 9 9\nl 1 2\n";
  const std::string file = put("Würfel #1.OBJ", obj);
  const RunResult result = runAirclay({"check", file, "--json"});
  EXPECT_EQ(result.status, 0) << result.errors;
  const json found = json::parse(result.output);
  EXPECT_EQ(found["kind"], "cage");
  EXPECT_EQ(found["format"], "OBJ");
  EXPECT_EQ(found["vertices"], 8);
  EXPECT_EQ(found["faces"], 6);
  EXPECT_EQ(found["quads"], 6);
  EXPECT_EQ(found["triangles"], 0);
  EXPECT_EQ(found["size_m"], json({200, 200, 200}));
  EXPECT_EQ(found["closed"], true);
  EXPECT_EQ(found["usable"], true);
  EXPECT_EQ(found["repairs"].size(), 2u);
  ASSERT_EQ(found["warnings"].size(), 1u);
  EXPECT_TRUE(contains(found["warnings"][0], "--units mm"));
  EXPECT_EQ(found["errors"].size(), 0u);

  const RunResult text = runAirclay({"check", file, "--units", "mm"});
  EXPECT_TRUE(contains(text.output, "200.0 x 200.0 x 200.0")) << text.output;
  EXPECT_TRUE(contains(text.output, "usable")) << text.output;
  EXPECT_TRUE(contains(text.errors, "repair: welded 16 vertices")) << text.errors;
  EXPECT_FALSE(contains(text.errors, "warning")) << text.errors;
}

TEST_F(CageApp, CheckListsAllProblems) {
  const std::string file =
      put("bad.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nf 1 2 3 4\nf 4 3 2 1\nf 1 2 5\n");
  const RunResult result = runAirclay({"check", file, "--json"});
  EXPECT_EQ(result.status, 1);
  const json found = json::parse(result.output);
  EXPECT_EQ(found["usable"], false);
  ASSERT_EQ(found["errors"].size(), 2u);
  EXPECT_TRUE(contains(found["errors"][0], "bad.obj: 1 face has no area: line 8"));
  EXPECT_TRUE(
      contains(found["errors"][1], "bad.obj: 1 face has the corners of another: line 7 repeats line 6"));
  const RunResult cut_off = runAirclay({"check", put("cut.ply", "ply\nformat ascii 1.0\n"), "--json"});
  EXPECT_EQ(cut_off.status, 1);
  EXPECT_EQ(json::parse(cut_off.output)["errors"].size(), 1u);
}

}  // namespace
}  // namespace airclay
