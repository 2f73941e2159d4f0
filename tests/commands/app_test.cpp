// SPDX-License-Identifier: MIT
// The program's options, errors and output files, on which scripts rely. No test here tracks a hand;
// tests/commands/sculpt_app_test.cpp does.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/images/image_file.h"
#include "capture/images/video_writer.h"
#include "engine/clay/presets.h"
#include "engine/clay/subdivide.h"
#include "engine/core/file_io.h"
#include "engine/hull/carve.h"
#include "engine/mesh/mesh_file.h"
#include "tests/support/program.h"
#include "tests/support/scene.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

using nlohmann::json;
using Strings = std::vector<std::string>;

/// The run fails with one line that contains `expected`, and prints nothing else.
void expectRefused(const Strings& arguments, int status, const std::string& expected) {
  std::string shown;
  for (const std::string& argument : arguments) shown += " " + argument;
  SCOPED_TRACE("airclay" + shown);
  const RunResult result = runAirclay(arguments);
  EXPECT_EQ(result.status, status);
  EXPECT_EQ(result.output, "");
  ASSERT_EQ(result.errorLines().size(), 1u) << result.errors;
  EXPECT_NE(result.errors.find(expected), std::string::npos) << result.errors;
}

json jsonOf(const Strings& arguments) {
  const RunResult result = runAirclay(arguments);
  EXPECT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(result.errors, "");
  return json::parse(result.output);
}

/// A take with only masks: a sphere in front of a ring of cameras, scaled by `scale`.
struct SphereTake {
  TemporaryFolder folder;
  Rig rig = ringRig(4);
  std::vector<Silhouette> masks = sphereMasks(rig, Vec3(0.03, -0.02, 0.01), 0.12);

  explicit SphereTake(double scale = 1) {
    for (Camera& camera : rig.cameras) camera.camera_from_world.translation() *= scale;
    rig.workspace.edge_m *= scale;
    writeRig(folder / "rig.toml", rig);
    for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
      const Camera& camera = rig.cameras[i];
      const std::filesystem::path masks_folder = folder.path() / "silhouettes" / camera.name;
      std::filesystem::create_directories(masks_folder);
      std::vector<std::uint8_t> rgba;
      for (const std::uint8_t pixel : masks[i].pixels) rgba.insert(rgba.end(), {pixel, pixel, pixel, 255});
      writePng(masks_folder / "000001.png", {camera.width, camera.height}, rgba);  // frame 0 is empty
    }
  }
  std::string path() const { return folder.path().string(); }
};

/// A take with videos of two cameras; tests damage it.
struct VideoTake {
  TemporaryFolder folder;
  Rig rig = ringRig(2, 64, 48);

  explicit VideoTake(int frames = 12, int frames_of_second = 12) {
    writeRig(folder / "rig.toml", rig);
    writeVideo("cam0", frames, 64, 48);
    writeVideo("cam1", frames_of_second, 64, 48);
  }
  void writeVideo(const std::string& name, int frames, int width, int height) {
    VideoWriter writer(folder / (name + ".mp4"), {{width, height}, 30, VideoWriter::Format::kBgr8});
    const std::vector<std::uint8_t> grey(std::size_t(3) * std::size_t(width) * std::size_t(height), 120);
    for (int i = 0; i < frames; ++i) writer.write(grey);
    writer.finish();
  }
  /// Rewrites rig.toml with the first `from` replaced by `to`.
  void changeRig(const std::string& from, const std::string& to) {
    std::string text = readWhole(folder / "rig.toml", 1 << 20);
    const std::size_t place = text.find(from);
    ASSERT_NE(place, std::string::npos) << text;
    folder.write("rig.toml", text.replace(place, from.size(), to));
  }
  Strings hull() const {
    return {"hull", folder.path().string(), "--frame", "11", "--out", (folder / "hull.ply").string()};
  }
};

/// A glTF binary that contains only this JSON (Khronos, glTF 2.0, section 4.4: header, then chunks).
std::string glb(std::string text) {
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const auto word = [](std::size_t value) {
    std::string bytes;
    for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(value >> shift & 0xff);
    return bytes;
  };
  return "glTF" + word(2) + word(text.size() + 20) + word(text.size()) + "JSON" + text;
}

TEST(App, EveryCommandHasHelp) {
  EXPECT_EQ(runAirclay({"--help"}).status, 0);
  EXPECT_EQ(runAirclay({"--version"}).output, "0.1.0\n");
  for (const char* command : {"demo",    "sculpt",  "track",  "evaluate", "hull",  "subdivide", "deform",
                              "figures", "compare", "bench",  "devices",  "board", "calibrate", "recalibrate",
                              "cameras", "offsets", "record", "serve",    "rig",   "check"}) {
    const RunResult result = runAirclay({command, "--help"});
    EXPECT_EQ(result.status, 0) << command;
    EXPECT_NE(result.output.find(std::string("airclay ") + command), std::string::npos) << result.output;
    EXPECT_EQ(result.errors, "");
    EXPECT_NE(runAirclay({"--help"}).output.find(std::string("\n  ") + command), std::string::npos)
        << command;
  }
}

TEST(App, WrongUsageExitsWithTwo) {
  expectRefused({}, 2, "--help");
  expectRefused({"knead"}, 2, "knead");
  expectRefused({"calibrate"}, 2, "calibrate");
  expectRefused({"--json", "devices"}, 2, "--json");
  expectRefused({"devices", "--colour"}, 2, "--colour");
  expectRefused({"devices", "extra"}, 2, "extra");
  expectRefused({"track"}, 2, "TAKE");
  expectRefused({"track", "take"}, 2, "--poses");
  expectRefused({"track", "take", "--poses", "x.tum", "--silhouettes", "loose"}, 2, "loose");
  expectRefused({"track", "take", "--poses", "x.tum", "--fit", "loose"}, 2, "loose");
  expectRefused({"track", "take", "--poses", "x.tum", "--units", "inch"}, 2, "inch");
  expectRefused({"track", "take", "--poses", "x.tum", "--background", "0"}, 2, "--background");
  expectRefused({"hull", "take", "--frame", "one", "--out", "x.ply"}, 2, "one");
  expectRefused({"subdivide", "tube"}, 2, "--out");
  expectRefused({"subdivide", "tube", "--out", "x.obj", "--rule", "loop"}, 2, "loop");
  expectRefused({"deform", "tube", "--out", "x.obj", "--moves", "m.csv"}, 2, "--cage-out");
  expectRefused({"sculpt"}, 2, "TAKE");
  expectRefused({"sculpt", "--camera", "left=0"}, 2, "--rig RIG.toml");
  expectRefused({"sculpt", "take", "--tool", "hammer"}, 2, "--tool");
  expectRefused({"sculpt", "take", "--place", "1,2"}, 2, "--place 1,2");
  expectRefused({"sculpt", "take", "--place", "1,2,3,4"}, 2, "--place 1,2,3,4");
  expectRefused({"sculpt", "take", "--place", "0,nan,0"}, 2, "--place 0,nan,0");
  expectRefused({"sculpt", "take", "--size", "-1"}, 2, "--size");
}

/// The run prints `deprecation` and then `error`.
void expectDeprecated(const Strings& arguments, const std::string& deprecation, const std::string& error) {
  const RunResult result = runAirclay(arguments);
  ASSERT_EQ(result.errorLines().size(), 2u) << result.errors;
  EXPECT_EQ(result.errorLines()[0], "airclay: " + deprecation);
  EXPECT_NE(result.errorLines()[1].find(error), std::string::npos) << result.errors;
}

TEST(App, FormerOptionNamesStillWork) {
  const TemporaryFolder folder;
  const std::string take = folder.path().string();
  folder.write("actions.txt", "not a list of actions\n");
  expectRefused({"sculpt", take, "--headless"}, 1, "actions.txt");
  expectRefused({"sculpt", take, "--headless", "--ignore-actions"}, 1, "rig.toml");
  expectDeprecated({"sculpt", take, "--headless", "--afresh"}, "--afresh is deprecated; use --ignore-actions",
                   "rig.toml");
  expectDeprecated({"sculpt", take, "--headless", "--unsteady"}, "--unsteady is deprecated; use --no-filter",
                   "--no-filter does not apply to a replay");
  const std::string image = take + "/none/rig.png";
  for (const Strings& command : {Strings{"calibrate", take}, Strings{"recalibrate", "old.toml", take}}) {
    Strings arguments = command;
    arguments.insert(arguments.end(), {"--out", take + "/rig.toml", "--picture", image});
    expectDeprecated(arguments, "--picture is deprecated; use --image", image);
  }
  expectDeprecated({"serve", "--camera", "left=0", "--for", "-1"}, "--for is deprecated; use --seconds",
                   "--seconds must be above 0");
}

TEST(App, FormerOptionNamesAreHidden) {
  std::string listed;
  for (const char* command : {"sculpt", "calibrate", "recalibrate", "serve"})
    listed += runAirclay({command, "--help"}).output;
  for (const char* format : {"man", "bash", "zsh", "fish", "markdown"})
    listed += runAirclay({"reference", format}).output;
  for (const char* current : {"ignore-actions", "no-filter", "image FILE.png"})
    EXPECT_NE(listed.find(current), std::string::npos) << current;
  for (const char* former : {"afresh", "unsteady", "picture", "--for "})
    EXPECT_EQ(listed.find(former), std::string::npos) << former;
}

TEST(App, SculptAcceptsADocument) {
  const TemporaryFolder folder;
  const std::string document = folder / "pot.clay";
  ASSERT_EQ(runAirclay({"new", document}).status, 0);
  expectRefused({"sculpt", document, "--clay", "vase"}, 2, "exclude each other");
  expectRefused({"sculpt", document, "--headless"}, 2, "airclay sculpt TAKE --clay " + document);
  expectRefused({"sculpt", folder / "take", "--headless"}, 1, folder / "take");
}

TEST(App, ListsDevices) {
  const json devices = jsonOf({"devices", "--json"}).at("devices");
  ASSERT_GE(devices.size(), 1u);
  const std::string name = devices[0].at("name");
  EXPECT_NE(runAirclay({"devices"}).output.find(name), std::string::npos);
  EXPECT_EQ(runAirclay({"devices", "--quiet"}).output, "");
}

TEST(App, MissingDriverExitsWithThree) {
  const RunOptions no_driver{{{"VK_ICD_FILENAMES", "/nowhere.json"}, {"VK_DRIVER_FILES", "/nowhere.json"}}};
  const RunResult result = runAirclay({"devices"}, no_driver);
  EXPECT_EQ(result.status, 3);
  EXPECT_EQ(result.errorLines().size(), 1u) << result.errors;
  const SphereTake take;
  const Strings hull = {"hull", take.path(), "--frame", "1", "--out", (take.folder / "hull.ply").string()};
  EXPECT_EQ(runAirclay(hull, no_driver).status, 3);
  Strings on_device = hull;
  on_device.insert(on_device.end(), {"--device", "999"});
  expectRefused(on_device, 3, "999");
  // subdivision and solve need no device
  EXPECT_EQ(runAirclay({"subdivide", "tube", "--out", (take.folder / "tube.obj").string()}, no_driver).status,
            0);
}

TEST(App, SubdivideWritesTheRowsOfTheMatrix) {
  const TemporaryFolder folder;
  const std::string out = folder / "surface.obj";
  for (const auto& [word, rule] : {std::pair{"catmull-clark", SubdivisionRule::kCatmullClark},
                                   std::pair{"printed", SubdivisionRule::kPrinted}}) {
    const json figures = jsonOf({"subdivide", "tube", "--rule", word, "--out", out, "--json"});
    EXPECT_EQ(figures, (json{{"control_points", 28}, {"data_points", 364}}));
    const PolygonMesh cage = presetCage("tube"), surface = readObj(out);
    const std::vector<Vec3> expected = dataPoints(subdivide(cage, 2, rule).matrix, cage.points);
    ASSERT_EQ(surface.points.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i)
      EXPECT_LT((surface.points[i] - expected[i]).norm(), 1e-9);  // nine significant digits of 0.1 m
  }
  EXPECT_EQ(jsonOf({"subdivide", "tube", "--levels", "1", "--out", out, "--json"})["data_points"], 98);
}

TEST(App, DeformMovesPointsToTheirTargets) {
  const TemporaryFolder folder;
  const std::string moves = folder.write("moves.csv", "index,x,y,z\n5,0.1,0.02,0.03\n200,-0.08,0.05,-0.01\n");
  const std::string out = folder / "surface.obj", cage_out = folder / "cage.obj";
  const json figures = jsonOf({"deform", "tube", "--moves", moves, "--solve", "touched", "--out", out,
                               "--cage-out", cage_out, "--json"});
  EXPECT_EQ(figures["control_points"], 28);
  const PolygonMesh surface = readObj(out), cage = readObj(cage_out);
  // two rows against 28 control points: the touched solve meets both exactly
  EXPECT_LT((surface.points[5] - Vec3(0.1, 0.02, 0.03)).norm(), 1e-8);
  EXPECT_LT((surface.points[200] - Vec3(-0.08, 0.05, -0.01)).norm(), 1e-8);
  const std::vector<Vec3> again =
      dataPoints(subdivide(cage, 2, SubdivisionRule::kCatmullClark).matrix, cage.points);
  for (std::size_t i = 0; i < again.size(); ++i) EXPECT_LT((surface.points[i] - again[i]).norm(), 1e-8);
}

TEST(App, CarvesMasksAtAnyScale) {
  for (const double scale : {1.0, 0.01, 200.0}) {
    SCOPED_TRACE(scale);
    const SphereTake take(scale);
    const std::string out = take.folder / "hull.ply";
    const json figures =
        jsonOf({"hull", take.path(), "--frame", "1", "--voxels", "64", "--out", out, "--json"});
    const VoxelGrid reference = carveReference(take.rig, take.masks, 64);
    const std::size_t occupied = hullStats(reference, take.rig.workspace).occupied;
    std::size_t doubtful = 0;  // where float and double may differ
    for (const std::uint8_t is_edge : edgeVoxels(take.rig, take.masks, 64, 0.01)) doubtful += is_edge;
    EXPECT_LT(doubtful, occupied / 10);
    EXPECT_NEAR(figures["occupied"].get<double>(), double(occupied), double(doubtful));
    const double voxel_m = take.rig.workspace.edge_m / 64;
    EXPECT_NEAR(figures["voxel_m"], voxel_m, 1e-9 * voxel_m);
    EXPECT_NEAR(figures["volume_m3"], figures["occupied"].get<double>() * std::pow(voxel_m, 3),
                1e-9 * std::pow(voxel_m, 3) * double(occupied));
    const std::string ply = readWhole(out, 1 << 24);
    EXPECT_NE(ply.find("element vertex " + figures["occupied"].dump() + "\n"), std::string::npos);
  }
}

TEST(App, HullOfAnEmptyFrameIsEmpty) {
  const SphereTake take;
  const json figures =
      jsonOf({"hull", take.path(), "--frame", "0", "--out", (take.folder / "hull.ply").string(), "--json"});
  EXPECT_EQ(figures["occupied"], 0);
  EXPECT_EQ(figures["volume_m3"], 0);
}

TEST(App, RejectsVoxelsOutOfRange) {
  const SphereTake take;
  for (const char* voxels : {"0", "-5", "1000000000"})
    expectRefused({"hull", take.path(), "--frame", "1", "--out", (take.folder / "hull.ply").string(),
                   "--voxels", voxels},
                  1, voxels);
}

TEST(App, RejectsUnwritableOutputs) {
  const SphereTake take;
  const std::string no_folder = take.folder / "nowhere/out";
  const std::string moves = take.folder.write("moves.csv", "index,x,y,z\n5,0.1,0.02,0.03\n");
  const std::string file = take.folder.write("file", "");
  expectRefused({"hull", take.path(), "--frame", "1", "--out", no_folder}, 1, no_folder);
  expectRefused({"track", take.path(), "--poses", no_folder}, 1, no_folder);
  expectRefused({"track", take.path(), "--poses", take.path()}, 1, take.path());
  expectRefused({"subdivide", "tube", "--out", no_folder}, 1, no_folder);
  expectRefused({"deform", "tube", "--moves", moves, "--out", no_folder, "--cage-out", no_folder}, 1,
                no_folder);
  expectRefused({"sculpt", take.path(), "--out", file + "/out"}, 1, file);
  expectRefused({"demo", "--out", file}, 1, file);
  expectRefused({"figures", "--out", file}, 1, file);
}

TEST(App, RejectsBadTakes) {
  const TemporaryFolder folder;
  expectRefused({"track", folder / "none", "--poses", folder / "x.tum"}, 1, folder / "none");
  expectRefused({"track", folder.path(), "--poses", folder / "x.tum"}, 1, "rig.toml");
  {
    const VideoTake take;
    std::filesystem::remove(take.folder / "cam1.mp4");
    expectRefused(take.hull(), 1, "cam1");
  }
  {
    VideoTake take;
    take.writeVideo("cam1", 12, 80, 48);
    expectRefused(take.hull(), 1, "80 x 48");
  }
  {
    const VideoTake take;
    const std::filesystem::path video = take.folder / "cam1.mp4";
    std::filesystem::resize_file(video, std::filesystem::file_size(video) / 2);
    expectRefused(take.hull(), 1, "cam1.mp4");
  }
  {
    const VideoTake take;
    Strings arguments = take.hull();
    arguments[3] = "12";
    expectRefused(arguments, 1, "0 to 11");
  }
  {
    const VideoTake take(8, 8);  // fewer frames than the ten of the background
    expectRefused(take.hull(), 1, "--background");
  }
}

TEST(App, RejectsBadRigs) {
  {
    VideoTake take;
    take.changeRig("translation = [", "translation = [nan, ");
    expectRefused(take.hull(), 1, "rig.toml");
  }
  {
    VideoTake take;
    take.changeRig("rotation = [", "rotation = [[1, 0, 0], [0, 2, 0], [0, 0, 1]] #");
    expectRefused(take.hull(), 1, "rotation");
  }
  {
    VideoTake take;
    take.changeRig("units", "unit");
    expectRefused(take.hull(), 1, "units");
    Strings arguments = take.hull();
    arguments.insert(arguments.end(), {"--units", "m"});
    EXPECT_EQ(runAirclay(arguments).status, 0);
  }
}

TEST(App, AcceptsVideosOfUnequalLength) {
  const VideoTake take(12, 15);
  const RunResult result = runAirclay(take.hull());
  EXPECT_EQ(result.status, 0);
  ASSERT_EQ(result.errorLines().size(), 1u) << result.errors;
  EXPECT_NE(result.errors.find("unequal length"), std::string::npos) << result.errors;
}

TEST(App, RejectsBadMeshesHandsAndMoves) {
  const TemporaryFolder folder;
  const std::string out = folder / "out.obj";
  const std::string range = folder.write("range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n");
  expectRefused({"subdivide", range, "--out", out}, 1, "range.obj");
  const std::string edge =
      folder.write("edge.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\nf 1 2 3\nf 2 1 4\nf 1 2 5\n");
  expectRefused({"subdivide", edge, "--out", out}, 1, "edge.obj");
  expectRefused({"subdivide", folder / "none.obj", "--out", out}, 1, "none.obj");
  expectRefused({"subdivide", "teapot", "--out", out}, 1, "teapot");
  expectRefused({"subdivide", "tube", "--levels", "0", "--out", out}, 1, "0");
  expectRefused({"subdivide", "tube", "--levels", "40", "--out", out}, 1, "40");
  const std::string moves = folder.write("moves.csv", "index,x,y,z\n364,0,0,0\n");
  expectRefused({"deform", "tube", "--moves", moves, "--out", out, "--cage-out", out}, 1, "moves.csv");
  EXPECT_FALSE(std::filesystem::exists(out));

  const SphereTake take;
  const std::string no_gltf = folder.write("none.glb", "this is no glTF");
  expectRefused({"track", take.path(), "--poses", folder / "x.tum", "--hand", no_gltf}, 1, "none.glb");
  const std::string no_joints = folder.write("empty.glb", glb(R"({"asset":{"version":"2.0"}})"));
  expectRefused({"track", take.path(), "--poses", folder / "x.tum", "--hand", no_joints}, 1, "empty.glb");
  expectRefused({"sculpt", take.path(), "--out", folder / "out", "--clay", range}, 1, "range.obj");
}

}  // namespace
}  // namespace airclay
