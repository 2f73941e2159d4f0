// SPDX-License-Identifier: MIT
// Rigs with moved cameras, corrected: points of the old world are found with the new rig, without alignment.
#include "capture/calibration/recalibration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "tests/support/calibration_scene.h"
#include "tests/support/program.h"
#include "tests/support/scene.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

using nlohmann::json;

/// 12 mm and 1.5 degrees.
Camera bumpedAway(const Camera& camera) {
  return bumped(camera, Vec3(0.008, -0.006, std::sqrt(0.000044)), 1.5 * M_PI / 180 * Vec3(0.6, 0, 0.8));
}

/// A rig as calibrated, the same rig after cameras moved, and views of a moving board after that.
struct BumpedScene {
  Rig old = ringRig(4, 640, 480), truth = old;
  Board board = a3Board();
  Wave wave;
  std::vector<Pose> boards;
  std::vector<CameraViews> views;

  explicit BumpedScene(const std::vector<std::size_t>& moved, const Wave& options = {.frames = 30})
      : wave(options) {
    for (const std::size_t camera : moved) truth.cameras[camera] = bumpedAway(truth.cameras[camera]);
    boards = wavedBoards(truth, board, wave);
    look();
  }
  void look() { views = seenCorners(truth, board, boards, wave); }
  Recalibration recalibrated(const RecalibrationOptions& options = {}) const {
    return recalibrate(board, old, views, options);
  }
};

bool anyMentions(const std::vector<std::string>& lines, const std::string& word) {
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(word) != std::string::npos; });
}

std::vector<std::size_t> movedOnes(const Recalibration& found) {
  std::vector<std::size_t> moved;
  for (std::size_t c = 0; c < found.changes.size(); ++c)
    if (found.changes[c].moved) moved.push_back(c);
  return moved;
}

/// The moves shift a point in the workspace by more than 5 mm; afterwards it is found in the old world.
void expectInPlace(const BumpedScene& scene, const Recalibration& found, double whole_mm = 0.3) {
  const CubeError error = cubeErrorInPlace(scene.truth, found.calibration.rig);
  EXPECT_LE(error.whole_mm, whole_mm);
  EXPECT_TRUE(found.world_kept);
  EXPECT_EQ(found.calibration.rig.workspace.center, scene.old.workspace.center);
  EXPECT_EQ(found.calibration.rig.workspace.edge_m, scene.old.workspace.edge_m);
}

TEST(Recalibration, FindsAMovedCameraAndKeepsTheWorld) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    SCOPED_TRACE(seed);
    BumpedScene scene({2}, {.frames = 30, .seed = seed});
    EXPECT_GE(cubeErrorInPlace(scene.truth, scene.old).whole_mm, 5);
    std::swap(scene.views[0], scene.views[3]);  // recordings list cameras in any order
    const Recalibration found = scene.recalibrated();
    expectInPlace(scene, found);
    EXPECT_EQ(movedOnes(found), std::vector<std::size_t>{2});
    EXPECT_NEAR(found.changes[2].moved_mm, 12, 0.8);
    EXPECT_NEAR(found.changes[2].turned_deg, 1.5, 0.05);
    // The displacement is gone; the two coordinates of noise remain.
    EXPECT_GE(found.changes[2].rms_px_before, 5);
    EXPECT_GE(found.rms_px_before, 2);
    EXPECT_LE(found.changes[0].rms_px_before, 2);
    EXPECT_NEAR(found.calibration.rms_px, scene.wave.noise_px * std::sqrt(2.0), 0.02);
    ASSERT_TRUE(found.calibration.scale_error_mm);
    EXPECT_LT(*found.calibration.scale_error_mm, 0.5);
    EXPECT_TRUE(found.calibration.warnings.empty()) << found.calibration.warnings[0];
    for (std::size_t c = 0; c < 4; ++c) {
      const Camera &now = found.calibration.rig.cameras[c], &before = scene.old.cameras[c];
      EXPECT_EQ(now.name, before.name);
      EXPECT_EQ(now.lens.fx, before.lens.fx);
      EXPECT_EQ(now.lens.cy, before.lens.cy);
      EXPECT_EQ(now.lens.distortion, before.lens.distortion);
      EXPECT_EQ(now.lens.monotonic_limit, before.lens.monotonic_limit);
    }
  }
}

TEST(Recalibration, CorrectsANoisyRig) {
  BumpedScene scene({1});
  const Wave calibrated{.frames = 60, .seed = 9};
  const Rig first = ringRig(4, 640, 480);
  scene.old = alignedTo(
      first, calibrate(scene.board, seenCorners(first, scene.board,
                                                wavedBoards(first, scene.board, calibrated), calibrated))
                 .rig);
  const Recalibration found = scene.recalibrated();
  expectInPlace(scene, found, 0.5);
  EXPECT_EQ(movedOnes(found), std::vector<std::size_t>{1});
}

TEST(Recalibration, UnmovedCamerasStayUnchanged) {
  const BumpedScene scene({});
  const Recalibration found = scene.recalibrated();
  expectInPlace(scene, found);
  EXPECT_TRUE(movedOnes(found).empty());
  EXPECT_LE(found.rms_px_before, 0.2);
  for (const CameraChange& change : found.changes) EXPECT_LE(change.moved_mm, 1);
}

TEST(Recalibration, FindsTwoMovedCamerasOfFour) {
  BumpedScene scene({});
  scene.truth.cameras[0] = bumped(scene.truth.cameras[0], Vec3(-0.02, 0.01, 0), Vec3(0, 0.03, 0.01));
  scene.truth.cameras[3] = bumpedAway(scene.truth.cameras[3]);
  scene.look();
  const Recalibration found = scene.recalibrated();
  expectInPlace(scene, found, 0.4);
  EXPECT_EQ(movedOnes(found), (std::vector<std::size_t>{0, 3}));
}

TEST(Recalibration, FindsACameraAtANewPlace) {
  BumpedScene scene({});
  scene.truth.cameras[3] = bumped(scene.truth.cameras[3], Vec3(0.3, -0.05, 0.1), Vec3(0.05, -0.27, 0.2));
  scene.look();
  const Recalibration found = scene.recalibrated();
  expectInPlace(scene, found);
  EXPECT_EQ(movedOnes(found), std::vector<std::size_t>{3});
}

TEST(Recalibration, TwoCamerasLeaveTheMovedOneUnknown) {
  BumpedScene scene({1});
  for (Rig* rig : {&scene.old, &scene.truth}) rig->cameras.resize(2);
  scene.views.resize(2);
  const Recalibration found = scene.recalibrated();
  EXPECT_FALSE(found.world_kept);
  EXPECT_TRUE(anyMentions(found.calibration.warnings, "no two cameras"));
  EXPECT_LE(cubeError(scene.truth, found.calibration.rig).whole_mm, 0.5);
}

TEST(Recalibration, ReportsThatAllMovedAndKeepsARelativeRig) {
  BumpedScene scene({});
  for (std::size_t c = 0; c < 4; ++c)
    scene.truth.cameras[c] = bumped(scene.truth.cameras[c], Vec3(0.02 * (double(c) - 1.4), 0.01, 0),
                                    Vec3(0.01 * double(c), 0.03, -0.02 * double(c)));
  scene.look();
  const Recalibration found = scene.recalibrated();
  EXPECT_FALSE(found.world_kept);
  EXPECT_EQ(movedOnes(found).size(), 4u);
  EXPECT_TRUE(anyMentions(found.calibration.warnings, "--world N"));
  EXPECT_LE(cubeError(scene.truth, found.calibration.rig).whole_mm, 0.3);
  // The workspace is approximately where the cameras placed it.
  EXPECT_LE(cubeErrorInPlace(scene.truth, found.calibration.rig).whole_mm, 50);

  // A board on the table defines the world: the workspace is above it.
  const Recalibration placed = scene.recalibrated({.world_frame = 7});
  EXPECT_FALSE(anyMentions(placed.calibration.warnings, "--world"));
  EXPECT_EQ(placed.calibration.rig.workspace.center, Vec3(0, 0, 0.3));
  const Vec3 middle = 0.5 * scene.board.square_m * Vec3(7, 5, 0);
  for (std::size_t c = 0; c < 4; ++c) {
    const Pose camera_from_board = scene.truth.cameras[c].camera_from_world * scene.boards[7];
    const Pose& camera_from_world = placed.calibration.rig.cameras[c].camera_from_world;
    EXPECT_LE((camera_from_world * Vec3(0, 0, 0) - camera_from_board * middle).norm(), 1e-3);
    EXPECT_LE((camera_from_world * Vec3(0, 0, 0.1) - camera_from_board * (middle - Vec3(0, 0, 0.1))).norm(),
              1e-3);
  }
  EXPECT_NE(messageOf([&] { scene.recalibrated({.world_frame = 1000}); }).find("--world 1000"),
            std::string::npos);
}

TEST(Recalibration, ReportsTwoPairsThatAgreeOnlyInternally) {
  BumpedScene scene({});
  // One tripod carries cameras 0 and 1 and was moved: both move about one point.
  const Pose push = Pose(Eigen::Translation3d(0.02, 0, 0) * Eigen::AngleAxisd(0.03, Vec3::UnitZ()));
  for (const std::size_t c : {0u, 1u})
    scene.truth.cameras[c].camera_from_world = scene.truth.cameras[c].camera_from_world * push;
  scene.look();
  const Recalibration found = scene.recalibrated();
  EXPECT_TRUE(found.world_kept);
  EXPECT_EQ(movedOnes(found).size(), 2u);
  for (const char* text : {"\"cam0\", \"cam1\"", "\"cam2\", \"cam3\"", "--world N"})
    EXPECT_TRUE(anyMentions(found.calibration.warnings, text)) << text;
}

TEST(Recalibration, ThreeSharedViewsAreEnough) {
  BumpedScene scene({2});
  std::map<int, BoardView>& views = scene.views[2].views;
  const auto isShared = [&](int frame) {
    return scene.views[1].views.contains(frame) || scene.views[3].views.contains(frame);
  };
  std::erase_if(views, [&](const auto& view) { return !isShared(view.first); });
  ASSERT_GT(views.size(), 3u);
  while (views.size() > 3) views.erase(std::prev(views.end()));
  const Recalibration found = scene.recalibrated();
  expectInPlace(scene, found, 0.8);
  EXPECT_EQ(found.calibration.cameras[2].shared_views, 3);
  EXPECT_EQ(movedOnes(found), std::vector<std::size_t>{2});
  views.erase(views.begin());
  EXPECT_NE(messageOf([&] { scene.recalibrated(); }).find("\"cam2\" sees the board well in 2 frames"),
            std::string::npos);
}

TEST(Recalibration, ReportsCamerasWithoutSharedViews) {
  BumpedScene scene({2});
  for (int frame = 0; frame < scene.wave.frames; ++frame)
    for (const int camera : frame % 2 ? std::vector{0, 1} : std::vector{2, 3})
      scene.views[std::size_t(camera)].views.erase(frame);
  const std::string message = messageOf([&] { scene.recalibrated(); });
  for (const char* word : {"\"cam0\", \"cam1\"", "\"cam2\", \"cam3\"", "at the same time"})
    EXPECT_NE(message.find(word), std::string::npos) << message;
}

TEST(Recalibration, PairwiseViewsAreEnough) {
  BumpedScene scene({1}, {.frames = 45});
  for (int frame = 0; frame < scene.wave.frames; ++frame)
    for (int camera = 0; camera < 4; ++camera)
      if (camera != frame % 3 && camera != frame % 3 + 1) scene.views[std::size_t(camera)].views.erase(frame);
  const Recalibration found = scene.recalibrated();
  expectInPlace(scene, found, 0.8);
  EXPECT_EQ(movedOnes(found), std::vector<std::size_t>{1});
}

TEST(Recalibration, AcceptsPartialAndUpsideDownBoards) {
  BumpedScene scene({0}, {.frames = 40});
  const Vec3 middle = 0.5 * scene.board.square_m * Vec3(7, 5, 0);
  const Pose half_turn = Pose(Eigen::Translation3d(middle) * Eigen::AngleAxisd(M_PI, Vec3::UnitZ()) *
                              Eigen::Translation3d(-middle));
  for (std::size_t frame = 0; frame < scene.boards.size(); frame += 2)
    scene.boards[frame] = scene.boards[frame] * half_turn;
  scene.look();
  for (CameraViews& camera : scene.views)
    for (auto& [frame, view] : camera.views) {
      BoardView part;  // a hand covers a different part for each camera
      const int first = (frame + int(camera.name.back())) % 3;
      for (std::size_t i = 0; i < view.ids.size(); ++i)
        if (const int column = view.ids[i] % scene.board.cornersX(); column >= first && column < first + 4)
          part.ids.push_back(view.ids[i]), part.pixels.push_back(view.pixels[i]);
      view = part;
    }
  const Recalibration found = scene.recalibrated();
  expectInPlace(scene, found, 0.4);
  EXPECT_EQ(movedOnes(found), std::vector<std::size_t>{0});
}

TEST(Recalibration, ToleratesOutliers) {
  const BumpedScene scene({2}, {.frames = 40, .outliers = 0.05});
  const Recalibration found = scene.recalibrated();
  expectInPlace(scene, found);
  EXPECT_EQ(movedOnes(found), std::vector<std::size_t>{2});
}

TEST(Recalibration, ReportsOnlyTheChangedLens) {
  for (const double zoom : {0.97, 1.02, 1.2}) {
    SCOPED_TRACE(zoom);
    BumpedScene scene({2});
    Camera& camera = scene.truth.cameras[1];
    camera.lens.fx *= zoom, camera.lens.fy *= zoom;
    camera.lens = withMonotonicRange(camera.lens);
    scene.look();
    const Recalibration found = scene.recalibrated();
    ASSERT_EQ(found.calibration.warnings.size(), 1u);
    for (const char* text : {"\"cam1\"", "zoom or focus", "airclay calibrate"})
      EXPECT_NE(found.calibration.warnings[0].find(text), std::string::npos) << found.calibration.warnings[0];
    EXPECT_NE(found.calibration.warnings[0].find(zoom > 1 ? "longer" : "shorter"), std::string::npos);
  }
}

TEST(Recalibration, RejectsABoardOfAnotherSize) {
  BumpedScene scene({2});
  scene.board.square_m *= 0.98, scene.board.marker_m *= 0.98;  // stated as 53.9 mm
  const std::string message = messageOf([&] { scene.recalibrated(); });
  EXPECT_NE(message.find("instead of 53.9 mm"), std::string::npos) << message;
  const std::size_t at = message.find("squares of ");
  ASSERT_NE(at, std::string::npos) << message;
  EXPECT_NEAR(std::stod(message.substr(at + 11)), 55, 0.06);
}

TEST(Recalibration, ReportsWrongBoardSizeIfAdjacentCamerasAgree) {
  BumpedScene scene({});
  const Camera aside = bumped(scene.old.cameras[0], Vec3(0.03, 0, 0), Vec3::Zero());
  for (Rig* rig : {&scene.old, &scene.truth}) {
    rig->cameras[1].camera_from_world = aside.camera_from_world;
  }
  scene.boards = wavedBoards(scene.truth, scene.board, scene.wave);
  scene.look();
  EXPECT_TRUE(scene.recalibrated().calibration.warnings.empty());
  scene.board.square_m *= 0.98, scene.board.marker_m *= 0.98;
  const Recalibration found = scene.recalibrated();
  EXPECT_TRUE(found.world_kept) << "the two cameras agree with each other";
  EXPECT_TRUE(anyMentions(found.calibration.warnings, "instead of 53.9 mm"));
}

TEST(Recalibration, ReportsCamerasThatTheRigLacks) {
  BumpedScene scene({});
  scene.views[1].name = "left";
  std::string message = messageOf([&] { scene.recalibrated(); });
  for (const char* text : {"the rig's \"cam1\"", "\"left\" is not in the rig", "expected"})
    EXPECT_NE(message.find(text), std::string::npos) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos);
  scene.views[1].name = "cam1";
  scene.views[3].width *= 2, scene.views[3].height *= 2;  // a valid scaling, but not a requested one
  message = messageOf([&] { scene.recalibrated(); });
  EXPECT_NE(message.find("\"cam3\": its images are 1280 x 960 pixels; expected the rig's 640 x 480"),
            std::string::npos)
      << message;
  scene.views.pop_back();
  EXPECT_NE(messageOf([&] { scene.recalibrated(); }).find("no images of the rig's \"cam3\""),
            std::string::npos);
}

/// The program, on rendered images.
TEST(RecalibrateApp, WritesTheRigAndNamesTheMovedCamera) {
  const TemporaryFolder folder;
  const BumpedScene scene({2}, {.frames = 16});
  const std::filesystem::path take = folder / "take";
  drawImages(take, scene.truth, scene.board, scene.boards);
  const std::string old = folder / "old.toml", out = folder / "new.toml", image = folder / "new.png";
  writeRig(old, scene.old);
  const auto run = [&](const std::string& rig, std::vector<std::string> arguments,
                       const RunOptions& options = {}) {
    arguments.insert(arguments.begin(), {"recalibrate", rig, take.string(), "--out", out, "--squares", "7x5",
                                         "--square-mm", "55", "--marker-mm", "41"});
    return runAirclay(arguments, options);
  };
  const RunResult result = run(old, {"--json", "--image", image});
  ASSERT_EQ(result.status, 0) << result.errors;
  const json figures = json::parse(result.output);
  EXPECT_LE(figures.at("rms_px").get<double>(), 0.35);
  EXPECT_GE(figures.at("rms_px_before").get<double>(), 2);
  EXPECT_LE(figures.at("scale_error_mm").get<double>(), 0.5);
  EXPECT_TRUE(figures.at("warnings").empty()) << figures["warnings"];
  ASSERT_EQ(figures.at("cameras").size(), 4u);
  for (std::size_t c = 0; c < 4; ++c) {
    const json& camera = figures["cameras"][c];
    EXPECT_EQ(camera.at("name"), scene.old.cameras[c].name);
    EXPECT_EQ(camera.at("moved").get<bool>(), c == 2);
    EXPECT_GE(camera.at("views").get<int>(), 3);
    EXPECT_LE(camera.at("rms_px").get<double>(), 0.35);
    EXPECT_GE(camera.at("rms_px_before").get<double>(), camera.at("rms_px").get<double>() - 0.05);
  }
  EXPECT_NEAR(figures["cameras"][2].at("moved_mm").get<double>(), 12, 0.8);
  EXPECT_NEAR(figures["cameras"][2].at("turned_deg").get<double>(), 1.5, 0.05);
  EXPECT_LE(cubeErrorInPlace(scene.truth, readRig(out)).whole_mm, 0.3);
  EXPECT_FALSE(cv::imread(image).empty());

  const RunResult printed = run(old, {"--world", "3"});
  EXPECT_EQ(printed.status, 0) << printed.errors;
  for (const char* text : {"12.0 mm", "unchanged", "moved: cam2", "frame 3", out.c_str()})
    EXPECT_NE(printed.output.find(text), std::string::npos) << text << "\n" << printed.output;
  EXPECT_EQ(readRig(out).workspace.center, Vec3(0, 0, 0.3));

  std::filesystem::remove(out);
  const auto refused = [&](const RunResult& faulty, int status, const std::string& expected) {
    EXPECT_EQ(faulty.status, status) << expected;
    EXPECT_EQ(faulty.errorLines().size(), 1u) << faulty.errors;
    EXPECT_NE(faulty.errors.find(expected), std::string::npos) << faulty.errors;
    EXPECT_FALSE(std::filesystem::exists(out));
  };
  Rig other = scene.old;
  other.cameras[0].name = "left";
  writeRig(folder / "other.toml", other);
  refused(run(folder / "other.toml", {}), 1, take.string() + ": there are no images of the rig's \"left\"");
  refused(run(folder / "none.toml", {}), 1, "none.toml");
  refused(run(old, {"--every", "9"}), 1, "at least 3");
  refused(run(old, {"--world", "16"}), 1, "0 to 15");
  refused(run(old, {"--check-square-mm", "5"}), 2, "--check-square-mm");
  RunOptions hasty;
  hasty.terminate_after_ms = 100;
  EXPECT_EQ(run(old, {}, hasty).status, 128 + SIGTERM);
  EXPECT_FALSE(std::filesystem::exists(out));
}

}  // namespace
}  // namespace airclay
