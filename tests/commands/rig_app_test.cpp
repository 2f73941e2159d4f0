// SPDX-License-Identifier: MIT
// `airclay rig` as a user runs it: conversion between programs' files, and reported problems.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "capture/images/image_file.h"
#include "capture/images/video_writer.h"
#include "engine/camera/rig_diagnostics.h"
#include "engine/core/file_io.h"
#include "engine/hull/silhouette_agreement.h"
#include "tests/support/program.h"
#include "tests/support/scene.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

using nlohmann::json;

/// A rig file, and a recording of it: masks of a sphere.
struct RigAndTake {
  TemporaryFolder folder;
  Rig rig = ringRig(4, 640, 480);
  std::string file = (folder / "rig.toml").string(), take = (folder / "take").string();

  RigAndTake() {
    writeRig(file, rig);
    const SilhouetteSet masks = sphereMasks(rig, Vec3(0.08, -0.05, 0.06), 0.07);
    for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
      const std::filesystem::path of_camera = folder.path() / "take" / "silhouettes" / rig.cameras[i].name;
      std::filesystem::create_directories(of_camera);
      std::vector<std::uint8_t> rgba;
      for (const std::uint8_t pixel : masks[i].pixels) rgba.insert(rgba.end(), {pixel, pixel, pixel, 255});
      writePng(of_camera / "000000.png", {rig.cameras[i].width, rig.cameras[i].height}, rgba);
    }
  }

  /// rig.toml with every `from` replaced.
  std::string changed(const std::string& name, const std::string& from, const std::string& to) const {
    std::string text = readWhole(file, 1 << 20);
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
      text.replace(at, from.size(), to);
    return folder.write(name, text).string();
  }
};

TEST(CheckApp, ReportsWhatWouldBeRead) {
  const RigAndTake scene;
  const RunResult of_rig = runAirclay({"check", scene.file, "--json"});
  ASSERT_EQ(of_rig.status, 0) << of_rig.errors << of_rig.output;
  const json rig = json::parse(of_rig.output);
  EXPECT_EQ(rig["kind"], "rig");
  EXPECT_EQ(rig["cameras"].size(), 4u);
  EXPECT_EQ(rig["cameras"][0]["width"], 640);
  EXPECT_TRUE(rig["usable"].get<bool>());

  const RunResult of_empty = runAirclay({"check", scene.take, "--json"});  // masks without a rig
  EXPECT_EQ(of_empty.status, 1);
  EXPECT_NE(of_empty.output.find("rig.toml"), std::string::npos) << of_empty.output;

  std::filesystem::copy_file(scene.file, std::filesystem::path(scene.take) / "rig.toml");
  const RunResult of_take = runAirclay({"check", scene.take, "--json"});
  ASSERT_EQ(of_take.status, 0) << of_take.errors << of_take.output;
  const json take = json::parse(of_take.output);
  EXPECT_EQ(take["kind"], "take");
  EXPECT_EQ(take["frames"], 1);
  EXPECT_TRUE(take["has_silhouettes"].get<bool>());
  EXPECT_FALSE(take["has_truth"].get<bool>());
}

TEST(RigApp, AcceptsAnyNames) {
  const TemporaryFolder folder;
  const std::filesystem::path take = folder / "my take #1 \u00e9\u4e2d";
  const std::vector<std::string> names = {"left cam", "#2", "Kamera \u00fc", "100% \"q\" 'x'"};
  Rig rig = ringRig(4, 64, 48);
  for (std::size_t i = 0; i < names.size(); ++i) {
    rig.cameras[i].name = names[i];
    std::filesystem::create_directories(take / names[i]);
    for (const char* image : {"000000.png", "000001.png"})
      writePng(take / names[i] / image, {64, 48}, std::vector<std::uint8_t>(64 * 48 * 4, 90));
  }
  writeRig(take / "rig.toml", rig);
  const RunResult check = runAirclay({"check", take.string(), "--background", "1", "--json"});
  ASSERT_EQ(check.status, 0) << check.errors << check.output;
  const json report = json::parse(check.output);
  EXPECT_EQ(report["frames"], 2);
  for (std::size_t i = 0; i < names.size(); ++i) EXPECT_EQ(report["cameras"][i]["name"], names[i]);

  for (const char* format : {"airclay", "anipose", "pose2sim"}) {
    const std::string out = (take / (std::string("out #\u00fc ") + format + ".toml")).string();
    const RunResult convert = runAirclay({"rig", "convert", take.string(), "--to", format, "--out", out});
    ASSERT_EQ(convert.status, 0) << convert.errors;
    const Rig found = readRig(out);
    for (std::size_t i = 0; i < names.size(); ++i) EXPECT_EQ(found.cameras[i].name, names[i]) << format;
  }
}

TEST(RigApp, ConvertsAnotherUpAxis) {
  const RigAndTake scene;
  writeRig(scene.folder / "y_down.toml", withUpAxis(scene.rig, Vec3::UnitY()));
  const std::string file = (scene.folder / "y_down.toml").string(),
                    out = (scene.folder / "out.toml").string();
  const RunResult check = runAirclay({"rig", "check", file});
  EXPECT_EQ(check.status, 0) << check.errors;
  EXPECT_NE(check.output.find("--up=-y"), std::string::npos) << check.output;
  EXPECT_NE(runAirclay({"check", file}).errors.find("--up=-y"), std::string::npos);
  ASSERT_EQ(runAirclay({"rig", "convert", file, "--up=-y", "--to", "airclay", "--out", out}).status, 0);
  EXPECT_EQ(runAirclay({"rig", "check", out}).output.find("--up"), std::string::npos);
}

TEST(RigApp, FolderThatCannotBeWrittenIsOneError) {
  const RigAndTake scene;
  for (const auto& [format, out] : {std::pair{"airclay", "/proc/rig.toml"},
                                    {"airclay", "/proc/airclay/rig.toml"},
                                    {"easymocap", "/proc/rig"}}) {
    const RunResult result = runAirclay({"rig", "convert", scene.file, "--to", format, "--out", out});
    EXPECT_EQ(result.status, 1) << result.errors;
    EXPECT_NE(result.errors.find(out), std::string::npos) << result.errors;
    EXPECT_EQ(std::count(result.errors.begin(), result.errors.end(), '\n'), 1) << result.errors;
  }
}

TEST(CheckApp, ReportsLoopsOfSymbolicLinks) {
  const RigAndTake scene;
  const std::filesystem::path take = scene.take;
  std::filesystem::copy_file(scene.file, take / "rig.toml");
  std::filesystem::create_directory_symlink("..", take / "silhouettes" / "cam0" / "up");
  EXPECT_EQ(runAirclay({"check", scene.take}).status, 0);  // a folder in itself is not followed
  std::filesystem::create_directory(take / "cam0");
  std::filesystem::create_symlink("000000.png", take / "cam0" / "000000.png");
  for (const char* loop : {"cam0/000000.png", "rig.toml"}) {
    const RunResult result = runAirclay({"check", scene.take});
    EXPECT_EQ(result.status, 1) << result.output;
    EXPECT_NE(result.errors.find(loop), std::string::npos) << result.errors;
    std::filesystem::remove(take / "rig.toml");
    std::filesystem::create_symlink("rig.toml", take / "rig.toml");
  }
}

TEST(CheckApp, ReportsRatesPixelsAndMissingImages) {
  const TemporaryFolder folder;
  const Rig rig = ringRig(3, 64, 48);
  writeRig(folder / "rig.toml", rig);
  for (std::size_t c = 0; c < 3; ++c) {
    const double rate_hz = c == 1 ? 15 : 30;
    VideoWriter writer(folder / (rig.cameras[c].name + ".mp4"),
                       {{64, 48}, rate_hz, VideoWriter::Format::kBgr8});
    for (int frame = 0; frame < (c == 1 ? 10 : 19); ++frame)
      writer.write(std::vector<std::uint8_t>(std::size_t(64 * 48 * 3), 128));
    writer.finish();
  }
  const RunResult ran = runAirclay({"check", folder.path().string(), "--json"});
  ASSERT_EQ(ran.status, 0) << ran.errors << ran.output;
  const json take = json::parse(ran.output);
  EXPECT_EQ(take["frames"], 19);
  EXPECT_NEAR(take["rate_hz"].get<double>(), 30, 1e-3);
  EXPECT_NEAR(take["cameras"][1]["rate_hz"].get<double>(), 15, 1e-3);
  EXPECT_EQ(take["cameras"][1]["pixels"], "yuv420p, 8 bits");
  EXPECT_EQ(take["cameras"][1]["missing_frames"], 0);
  EXPECT_NE(take["warnings"].dump().find("has no image in 9"), std::string::npos) << ran.output;
  const RunResult unknown = runAirclay({"check", folder.path().string(), "--offset", "middle=3"});
  EXPECT_NE(unknown.status, 0);
  EXPECT_NE(unknown.errors.find("\"middle\""), std::string::npos) << unknown.errors;
  EXPECT_EQ(runAirclay({"check", folder.path().string(), "--offset", "cam1"}).status, 2);
}

TEST(CheckApp, ListsEveryError) {
  const RigAndTake scene;
  const std::string file = scene.changed("bad.toml", "distortions", "distortion");
  const RunResult result = runAirclay({"check", file});
  EXPECT_EQ(result.status, 1);
  EXPECT_GE(result.errorLines().size(), 4u) << result.errors;  // one per camera
  EXPECT_EQ(runAirclay({"check", (scene.folder / "none").string()}).status, 1);
}

TEST(RigApp, ConversionRoundTrips) {
  const RigAndTake scene;
  std::string from = scene.file;
  for (const std::string form : {"anipose", "caliscope", "pose2sim", "easymocap", "airclay"}) {
    const std::string out = (scene.folder / (form == "easymocap" ? "easymocap" : form + ".toml")).string();
    const RunResult result = runAirclay({"rig", "convert", from, "--to", form, "--out", out});
    ASSERT_EQ(result.status, 0) << result.errors;
    EXPECT_NE(result.output.find("4 cameras"), std::string::npos) << result.output;
    EXPECT_EQ(result.errorLines().size(), form == "caliscope" ? 4u : 0u)
        << result.errors;  // names for its videos
    from = out;
  }
  const Rig back = readRig(from);
  ASSERT_EQ(back.cameras.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(back.cameras[i].name, scene.rig.cameras[i].name);
    EXPECT_EQ(back.cameras[i].width, scene.rig.cameras[i].width);
    const auto stray =
        back.cameras[i].camera_from_world.matrix() - scene.rig.cameras[i].camera_from_world.matrix();
    EXPECT_LE(stray.norm(), 1e-9);
  }
}

TEST(RigApp, ConvertsUnitsSizesAndTheWorkspace) {
  const RigAndTake scene;
  const std::string out = (scene.folder / "out.toml").string();
  const std::string bare = scene.changed("bare.toml", "units = \"m\"", "adjusted = false");
  const RunResult refused = runAirclay({"rig", "convert", bare, "--to", "airclay", "--out", out});
  EXPECT_EQ(refused.status, 1);
  EXPECT_NE(refused.errors.find("--units"), std::string::npos) << refused.errors;
  ASSERT_EQ(runAirclay({"rig", "convert", bare, "--units", "m", "--edge", "0.4", "--center", "0.1,0,-0.05",
                        "--to", "airclay", "--out", out})
                .status,
            0);
  EXPECT_EQ(readRig(out).workspace.edge_m, 0.4);
  EXPECT_EQ(readRig(out).workspace.center, Vec3(0.1, 0, -0.05));
  ASSERT_EQ(runAirclay({"rig", "convert", out, "--center", "auto", "--to", "airclay", "--out", out}).status,
            0);
  EXPECT_LE(readRig(out).workspace.center.norm(), 1e-9);  // where the ring of cameras looks

  const std::string sizeless = scene.changed("sizeless.toml", "size = [640, 480]\n", "");
  const RunResult unknown = runAirclay({"rig", "convert", sizeless, "--to", "airclay", "--out", out});
  EXPECT_EQ(unknown.status, 1);
  EXPECT_NE(unknown.errors.find("size is missing"), std::string::npos) << unknown.errors;
  ASSERT_EQ(
      runAirclay({"rig", "convert", sizeless, "--take", scene.take, "--to", "airclay", "--out", out}).status,
      0);
  EXPECT_EQ(readRig(out).cameras[3].height, 480);
}

TEST(RigApp, WrongUsageExitsWithTwo) {
  const RigAndTake scene;
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"rig"}, "subcommand"},
      {{"rig", "convert", scene.file, "--out", "x.toml"}, "--to"},
      {{"rig", "convert", scene.file, "--to", "anipose"}, "--out"},
      {{"rig", "convert", scene.file, "--to", "matlab", "--out", "x.toml"}, "matlab"},
      {{"rig", "convert", scene.file, "--to", "easymocap", "--out", "x.yml"}, "folder"},
      {{"rig", "check", scene.file, "--units", "inch"}, "inch"},
      {{"rig", "check", scene.file, "--center", "1,2"}, "--center 1,2"},
      {{"rig", "check", scene.file, "--edge", "0"}, "--edge"},
      {{"rig", "check"}, "RIG"},
  };
  for (const auto& [arguments, expected] : cases) {
    const RunResult result = runAirclay(arguments);
    EXPECT_EQ(result.status, 2) << expected;
    EXPECT_EQ(result.errorLines().size(), 1u) << result.errors;
    EXPECT_NE(result.errors.find(expected), std::string::npos) << result.errors;
  }
}

TEST(RigApp, GoodRigPasses) {
  const RigAndTake scene;
  const RunResult result = runAirclay({"rig", "check", scene.file});
  EXPECT_EQ(result.status, 0);
  EXPECT_EQ(result.errors, "");
  EXPECT_NE(result.output.find("no problems found"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("640 x 480"), std::string::npos) << result.output;

  const RunResult with_take = runAirclay({"rig", "check", scene.file, scene.take, "--json"});
  EXPECT_EQ(with_take.status, 0) << with_take.errors;
  const json report = json::parse(with_take.output);
  EXPECT_EQ(report.at("ok"), true);
  EXPECT_TRUE(report.at("findings").empty()) << report.dump();
  ASSERT_EQ(report.at("cameras").size(), 4u);
  const json& camera = report.at("cameras")[1];
  EXPECT_EQ(camera.at("name"), "cam1");
  EXPECT_NEAR(camera.at("distance_m"), std::hypot(1, 0.75), 1e-9);
  EXPECT_GE(camera.at("explained"), 0.99);
}

TEST(RigApp, WrongRigFailsWithAllErrors) {
  RigAndTake scene;
  for (Camera& camera : scene.rig.cameras) camera.camera_from_world = camera.camera_from_world.inverse();
  writeRig(scene.file, scene.rig);
  const RunResult result = runAirclay({"rig", "check", scene.file, scene.take, "--json"});
  EXPECT_EQ(result.status, 1);
  EXPECT_EQ(result.errorLines().size(), 1u) << result.errors;
  const json report = json::parse(result.output);
  EXPECT_EQ(report.at("ok"), false);
  int faults = 0, suspicions = 0, inverse = 0;
  for (const json& finding : report.at("findings")) {
    faults += finding.at("severity") == "fault";
    suspicions += finding.at("severity") == "suspicion";
    inverse += std::string(finding.at("what")).find("world_from_camera") != std::string::npos;
  }
  EXPECT_GE(faults, 1);
  EXPECT_GE(suspicions, 1);
  EXPECT_EQ(inverse, 2) << report.dump(1);  // reported by the workspace check and by the silhouettes

  const RunResult quiet = runAirclay({"rig", "check", scene.file, "--quiet"});
  EXPECT_EQ(quiet.output, "");
  EXPECT_EQ(quiet.status, 1);
  const RunResult missing = runAirclay({"rig", "check", (scene.folder / "none.toml").string()});
  EXPECT_EQ(missing.status, 1);
  EXPECT_NE(missing.errors.find("none.toml"), std::string::npos) << missing.errors;
}

}  // namespace
}  // namespace airclay
