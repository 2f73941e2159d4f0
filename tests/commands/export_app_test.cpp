// SPDX-License-Identifier: MIT
// `airclay export` as a user runs it: output files, messages and errors.
#include <gtest/gtest.h>

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/Importer.hpp>
#include <nlohmann/json.hpp>

#include "engine/clay/document.h"
#include "engine/clay/presets.h"
#include "engine/clay/subdivide.h"
#include "engine/mesh/mesh_file.h"
#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

using nlohmann::json;

unsigned facesIn(const std::filesystem::path& file) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(file.string(), 0);
  return scene && scene->mNumMeshes == 1 ? scene->mMeshes[0]->mNumFaces : 0;
}

struct ExportApp : ::testing::Test {
  TemporaryFolder folder;
  std::string at(const std::string& name) const { return (folder / name).string(); }
};

TEST_F(ExportApp, ReportsWhetherThePartIsPrintable) {
  const RunResult closed = runAirclay({"export", "cube", "--what", "cage", "--out", at("cube.stl")});
  EXPECT_EQ(closed.status, 0) << closed.errors;
  EXPECT_NE(closed.output.find("12 triangles, 200.0 x 200.0 x 200.0 mm"), std::string::npos) << closed.output;
  EXPECT_NE(closed.output.find("watertight, 8000.0 cm3"), std::string::npos) << closed.output;
  const RunResult open = runAirclay({"export", "tube", "--out", at("tube.stl")});
  EXPECT_EQ(open.status, 0) << open.errors;
  EXPECT_NE(open.output.find("56 open edges: cannot be 3D-printed"), std::string::npos) << open.output;
  EXPECT_EQ(facesIn(at("tube.stl")), 672u);  // 336 quads
}

TEST_F(ExportApp, JsonCountsTheFileContent) {
  const std::vector<std::pair<std::string, unsigned>> faces = {
      {"a.obj", 24u * 16}, {"a.ply", 24u * 16}, {"a.stl", 48u * 16}, {"a.glb", 48u * 16}};
  PolygonMesh cube = presetCage("cube");
  const Subdivision subdivision = subdivide(cube, 3, SubdivisionRule::kPrinted);
  for (const auto& [name, count] : faces) {
    const RunResult result =
        runAirclay({"export", "cube", "--levels", "3", "--rule", "printed", "--json", "--out", at(name)});
    ASSERT_EQ(result.status, 0) << result.errors;
    const json report = json::parse(result.output);
    EXPECT_EQ(report["faces"], count) << name;
    EXPECT_EQ(facesIn(at(name)), count) << name;
    EXPECT_EQ(report["vertices"], subdivision.matrix.rows());
    EXPECT_EQ(report["watertight"], true);
    EXPECT_EQ(report["open_edges"], 0);
    EXPECT_GT(report["volume_cm3"], 1000);
    EXPECT_LT(report["volume_cm3"], 8000);
  }
  // OBJ keeps the order of subdivide's points.
  const std::vector<Vec3> points = dataPoints(subdivision.matrix, cube.points);
  const PolygonMesh read = readObj(at("a.obj"));
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_LT((read.points[i] - points[i]).norm(), 1e-9);
}

TEST_F(ExportApp, ReadsCagesFromObj) {
  writeObj(folder / "cage.obj", presetCage("slab"));
  const RunResult result =
      runAirclay({"export", at("cage.obj"), "--what", "cage", "--json", "--out", at("b.obj")});
  ASSERT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(readObj(at("b.obj")).faces, presetCage("slab").faces);
}

TEST_F(ExportApp, ReadsDocuments) {
  ClayState state{presetCage("vase"), SubdivisionRule::kPrinted, 1, &kSolveAll};
  {
    Document document = Document::create(folder / "vase.clay", state);
    state.cage.points[0] += Vec3(0.01, 0.02, 0.03);
    document.commit("Push", state);
  }
  // The document's own level and rule, and the state after the last edit.
  ASSERT_EQ(runAirclay({"export", at("vase.clay"), "--out", at("a.obj")}).status, 0);
  const Subdivision own = subdivide(state.cage, 1, SubdivisionRule::kPrinted);
  const std::vector<Vec3> points = dataPoints(own.matrix, state.cage.points);
  const PolygonMesh read = readObj(at("a.obj"));
  ASSERT_EQ(read.points.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_LT((read.points[i] - points[i]).norm(), 1e-9);
  // Options override them.
  ASSERT_EQ(runAirclay({"export", at("vase.clay"), "--levels", "2", "--out", at("b.obj")}).status, 0);
  const PolygonMesh finer = readObj(at("b.obj"));
  const Subdivision second = subdivide(state.cage, 2, SubdivisionRule::kPrinted);
  EXPECT_LT((finer.points[0] - dataPoints(second.matrix, state.cage.points)[0]).norm(), 1e-9);
  ASSERT_EQ(runAirclay({"export", at("vase.clay"), "--what", "cage", "--out", at("c.obj")}).status, 0);
  EXPECT_EQ(readObj(at("c.obj")).faces, state.cage.faces);
}

TEST_F(ExportApp, ErrorsAreOneLine) {
  const std::vector<std::tuple<std::vector<std::string>, int, std::string>> cases = {
      {{"export", "ball", "--out", at("a.fbx")}, 2, ".obj, .ply, .stl or .glb"},
      {{"export", "ball", "--what", "hull", "--out", at("a.stl")}, 2, "--what"},
      {{"export", "ball", "--what", "cage", "--levels", "2", "--out", at("a.stl")}, 2, "--levels"},
      {{"export", "ball", "--levels", "99", "--out", at("a.stl")}, 1, "level"},
      {{"export", at("none.clay"), "--out", at("a.stl")}, 1, "none.clay"},
      {{"export", "bell", "--out", at("a.stl")}, 1, "bell"},
      {{"export", "ball", "--out", at("none/a.stl")}, 1, "no such folder"},
      {{"export", "ball"}, 2, "--out"},
  };
  for (const auto& [arguments, status, expected] : cases) {
    SCOPED_TRACE(arguments.back());
    const RunResult result = runAirclay(arguments);
    EXPECT_EQ(result.status, status);
    EXPECT_EQ(result.output, "");
    EXPECT_EQ(result.errorLines().size(), 1u) << result.errors;
    EXPECT_NE(result.errors.find(expected), std::string::npos) << result.errors;
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace airclay
