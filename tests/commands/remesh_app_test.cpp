// SPDX-License-Identifier: MIT
// `airclay remesh` as a user runs it.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/clay/document.h"
#include "engine/clay/presets.h"
#include "engine/mesh/mesh_file.h"
#include "tests/support/cage_files.h"
#include "tests/support/program.h"
#include "tests/support/solids.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

using nlohmann::json;

struct RemeshApp : ::testing::Test {
  TemporaryFolder folder;
  std::string at(const std::string& name) const { return (folder / name).string(); }
};

/// A ball of 40 mm radius, in millimetres.
PolygonMesh ballInMillimetres() {
  const TriangleMesh ball = ballMesh(Vec3(10, 20, 30), 40, 4);
  PolygonMesh mesh{ball.vertices, {}};
  for (const auto& triangle : ball.triangles) mesh.faces.emplace_back(triangle.begin(), triangle.end());
  return mesh;
}

TEST_F(RemeshApp, StlBecomesACage) {
  folder.write("ball.stl", stlBinaryOf(ballInMillimetres()));
  const RunResult result =
      runAirclay({"remesh", at("ball.stl"), "--faces", "600", "--json", "--out", at("cage.obj")});
  ASSERT_EQ(result.status, 0) << result.errors;
  const json report = json::parse(result.output);
  const PolygonMesh cage = readObj(at("cage.obj"));
  EXPECT_EQ(report["faces"], cage.faces.size());
  EXPECT_NEAR(double(cage.faces.size()), 600, 18);
  EXPECT_LT(report["hausdorff_mm"], report["edge_mm"].get<double>() / 4);
  EXPECT_LT(std::abs(report["volume_change_percent"].get<double>()), 0.5);
  EXPECT_NEAR(report["volume_cm3"].get<double>(), 4 * M_PI / 3 * 64, 1.4);
  for (const Vec3& point : meshAtLevel(cage, 2, SubdivisionRule::kCatmullClark).points)
    EXPECT_NEAR((point - Vec3(0.01, 0.02, 0.03)).norm(), 0.04, 1e-3 * report["edge_mm"].get<double>() / 4);
}

TEST_F(RemeshApp, FormatsOfOneMeshGiveOneCage) {
  PolygonMesh mesh = ballInMillimetres();
  for (Vec3& point : mesh.points) point = (point * 16).array().round() / 16384;  // exact in every format
  for (const auto& [name, content] : cageFiles(mesh)) {
    folder.write(name, content);
    const RunResult result = runAirclay({"remesh", at(name), "--units", "m", "--up", "z", "--edge-mm", "9",
                                         "--json", "--out", at("cage.obj")});
    ASSERT_EQ(result.status, 0) << name << ": " << result.errors;
    const json report = json::parse(result.output);
    EXPECT_NEAR(report["edge_mm"].get<double>(), 9, 0.3) << name;
    EXPECT_NEAR(report["volume_cm3"].get<double>(), 4 * M_PI / 3 * std::pow(4 / 1.024, 3), 1.3) << name;
  }
}

TEST_F(RemeshApp, OpenInputIsRefusedUnlessThickened) {
  const RunResult open = runAirclay({"remesh", "tube", "--out", at("cage.obj")});
  EXPECT_EQ(open.status, 1);
  ASSERT_EQ(open.errorLines().size(), 1u) << open.errors;
  EXPECT_NE(open.errors.find("tube: remesh: the surface is open"), std::string::npos) << open.errors;
  EXPECT_NE(open.errors.find("--thicken MM"), std::string::npos) << open.errors;
  EXPECT_FALSE(std::filesystem::exists(at("cage.obj")));
  const RunResult wall = runAirclay({"remesh", "tube", "--thicken", "16", "--json", "--out", at("cage.obj")});
  ASSERT_EQ(wall.status, 0) << wall.errors;
  const json report = json::parse(wall.output);
  EXPECT_NEAR(report["edge_mm"].get<double>(), 8, 0.3);
  EXPECT_LT(report["hausdorff_mm"], report["edge_mm"].get<double>() / 4);
  EXPECT_LT(std::abs(report["volume_change_percent"].get<double>()), 0.5);
  EXPECT_EQ(eulerCharacteristic(readObj(at("cage.obj"))), 0);
}

TEST_F(RemeshApp, CageOrMesh) {
  folder.write("cube.obj", objOf(cubeCage(0.1)));
  const auto volume = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"remesh", at("cube.obj"), "--json", "--out", at("cage.obj")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const RunResult result = runAirclay(arguments);
    EXPECT_EQ(result.status, 0) << result.errors;
    return json::parse(result.output)["volume_cm3"].get<double>();
  };
  EXPECT_NEAR(volume({"--as", "mesh"}), 1000, 5);
  EXPECT_LT(volume({}), 600);  // quads: a cage, whose surface is round
  EXPECT_NEAR(volume({"--as", "cage"}), volume({}), 1e-9);
}

// The edge that both boxes share has four faces: not a cage, but a closed surface.
TEST_F(RemeshApp, NonManifoldEdgesAreAccepted) {
  PolygonMesh boxes = cubeCage(20);
  for (const std::vector<int>& face : cubeCage(20).faces) {
    std::vector<int>& moved = boxes.faces.emplace_back(face);
    for (int& corner : moved) corner += 8;
  }
  for (const Vec3& point : cubeCage(20).points) boxes.points.push_back(point + Vec3(20, 20, 0));
  folder.write("boxes.stl", stlBinaryOf(boxes));
  const RunResult result = runAirclay({"remesh", at("boxes.stl"), "--json", "--out", at("cage.obj")});
  ASSERT_EQ(result.status, 0) << result.errors;
  EXPECT_NE(result.errors.find("more than two faces"), std::string::npos) << result.errors;
  EXPECT_NEAR(json::parse(result.output)["volume_cm3"].get<double>(), 16, 0.08);
  EXPECT_NO_THROW(readObj(at("cage.obj")));
}

TEST_F(RemeshApp, ReadsDocuments) {
  Document::create(folder / "a.clay", {presetCage("ball"), SubdivisionRule::kPrinted, 2, &kSolveAll});
  const RunResult result = runAirclay({"remesh", at("a.clay"), "--faces", "400", "--out", at("cage.obj")});
  EXPECT_EQ(result.status, 0) << result.errors;
  EXPECT_NE(result.output.find("quads of "), std::string::npos) << result.output;
  EXPECT_NEAR(double(readObj(at("cage.obj")).faces.size()), 400, 12);
}

TEST_F(RemeshApp, InvalidOptionsAreUsageErrors) {
  const std::vector<std::vector<std::string>> wrong = {
      {"--faces", "20"}, {"--edge-mm", "0"}, {"--edge-mm", "5", "--faces", "100"}, {"--thicken", "-1"}};
  for (const auto& options : wrong) {
    std::vector<std::string> arguments = {"remesh", "ball", "--out", at("cage.obj")};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const RunResult result = runAirclay(arguments);
    EXPECT_EQ(result.status, 2) << result.errors;
    EXPECT_EQ(result.errorLines().size(), 1u) << result.errors;
  }
  const RunResult small = runAirclay({"remesh", "ball", "--edge-mm", "0.01", "--out", at("cage.obj")});
  EXPECT_EQ(small.status, 1);
  EXPECT_NE(small.errors.find("expected --edge-mm from"), std::string::npos) << small.errors;
  EXPECT_FALSE(std::filesystem::exists(at("cage.obj")));
}

}  // namespace
}  // namespace airclay
