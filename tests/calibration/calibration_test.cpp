// SPDX-License-Identifier: MIT
// Calibration compared with true rigs: the errors of points in the workspace, not of parameters.
#include "capture/calibration/calibration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numeric>
#include <opencv2/imgcodecs.hpp>

#include "capture/calibration/board_recording.h"
#include "capture/takes/synthetic.h"
#include "engine/core/error.h"
#include "engine/pipeline.h"
#include "tests/support/board_scene.h"
#include "tests/support/calibration_scene.h"
#include "tests/support/gpu_fixture.h"
#include "tests/support/hand_scene.h"
#include "tests/support/program.h"
#include "tests/support/scene.h"
#include "tests/support/small_take.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

/// A true rig, and its cameras' views of a moving board.
struct Scene {
  Rig rig = ringRig(4, 640, 480);
  Board board = a3Board();
  Wave wave;
  std::vector<Pose> boards;
  std::vector<CameraViews> views;

  explicit Scene(const Wave& options = {}, const std::optional<Lens>& lens = std::nullopt) : wave(options) {
    if (lens)
      for (Camera& camera : rig.cameras) camera.lens = withMonotonicRange(*lens);
    boards = wavedBoards(rig, board, wave);
    views = seenCorners(rig, board, boards, wave);
  }
  Calibration calibrated(const CalibrationOptions& options = {}) const {
    return calibrate(board, views, options);
  }
};

Lens lensOf(LensModel model, double focal_px, const std::array<double, 8>& distortion) {
  Lens lens;
  lens.model = model;
  lens.fx = focal_px, lens.fy = 1.01 * focal_px, lens.cx = 321.3, lens.cy = 236.9;
  lens.distortion = distortion;
  return lens;
}

void expectAccurate(const Rig& truth, const Rig& found) {
  const CubeError error = cubeError(truth, found);
  EXPECT_LE(error.central_mm, 0.12);
  EXPECT_LE(error.whole_mm, 0.7);
  EXPECT_NEAR(error.scale, 1, 0.0005);
}

bool anyMentions(const std::vector<std::string>& lines, const std::string& word) {
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(word) != std::string::npos; });
}

TEST(Calibration, CubeErrorIsZeroForTruthAndDetectsScale) {
  const Rig truth = ringRig(4, 640, 480);
  Rig moved = truth;
  const Pose shift = Pose(Eigen::Translation3d(0.1, 0.2, -0.3) * Eigen::AngleAxisd(0.4, Vec3::UnitX()));
  for (Camera& camera : moved.cameras) camera.camera_from_world = camera.camera_from_world * shift;
  EXPECT_LE(cubeError(truth, moved).whole_mm, 1e-6);
  for (Camera& camera : moved.cameras) camera.camera_from_world.translation() *= 1.01;
  const CubeError error = cubeError(truth, moved);
  EXPECT_NEAR(error.scale, 1.01, 1e-6);
  // 1 % of the RMS distance from the middle of a cube of points, edge sqrt(3)/2 * sqrt(1/3 * (1 + 2/12)).
  EXPECT_NEAR(error.whole_mm, 0.01 * 600 / 2 * std::sqrt(1 + 2.0 / 12), 0.3);
}

TEST(Calibration, FindsTheRigFromNoisyCorners) {
  const Scene scene;
  const Calibration found = scene.calibrated();
  expectAccurate(scene.rig, found.rig);
  EXPECT_LE(found.rms_px, 0.35);
  // Two coordinates of the noise; a lower value would mean overfitting.
  EXPECT_NEAR(found.rms_px, scene.wave.noise_px * std::sqrt(2.0), 0.02);
  ASSERT_TRUE(found.scale_error_mm);
  EXPECT_LT(*found.scale_error_mm, 0.5);
  ASSERT_EQ(found.baselines.size(), 6u);
  for (const Baseline& baseline : found.baselines) {
    const auto eye = [&](int camera) -> Vec3 {
      return scene.rig.cameras[std::size_t(camera)].camera_from_world.inverse().translation();
    };
    EXPECT_NEAR(baseline.metres, (eye(baseline.a) - eye(baseline.b)).norm(),
                3e-3);  // along the rays, together with the focal length
  }
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    EXPECT_EQ(found.cameras[i].views, static_cast<int>(scene.views[i].views.size()));
    EXPECT_GT(found.cameras[i].coverage, 0.3);
  }
  EXPECT_TRUE(found.warnings.empty()) << found.warnings[0];
}

TEST(Calibration, ToleratesOutliers) {
  Wave wave;
  wave.outliers = 0.05;
  const Scene scene(wave);
  const Calibration found = scene.calibrated();
  expectAccurate(scene.rig, found.rig);
  EXPECT_LE(found.rms_px, 0.35);
  int seen = 0, dropped = 0;
  for (const CameraQuality& quality : found.cameras)
    seen += quality.corners + quality.dropped, dropped += quality.dropped;
  EXPECT_NEAR(static_cast<double>(dropped) / seen, wave.outliers, 0.02);
}

TEST(Calibration, ChainsPairwiseOverlaps) {
  Scene scene;
  // Each instant belongs to one pair of neighbours: 0-1, 1-2, 2-3; cameras 3 and 0 never share a board.
  for (int frame = 0; frame < scene.wave.frames; ++frame)
    for (int camera = 0; camera < 4; ++camera)
      if (camera != frame % 3 && camera != frame % 3 + 1) scene.views[std::size_t(camera)].views.erase(frame);
  const Calibration found = scene.calibrated();
  const CubeError error = cubeError(scene.rig, found.rig);
  EXPECT_LE(error.central_mm, 0.3);  // a third of the views
  EXPECT_LE(error.whole_mm, 0.7);
}

TEST(Calibration, ReportsCamerasWithoutSharedViews) {
  Scene scene;
  for (int frame = 0; frame < scene.wave.frames; ++frame)
    for (const int camera : frame % 2 ? std::vector{0, 1} : std::vector{2, 3})
      scene.views[std::size_t(camera)].views.erase(frame);
  const std::string message = messageOf([&] { scene.calibrated(); });
  for (const char* word : {"\"cam0\", \"cam1\"", "\"cam2\", \"cam3\"", "at the same time"})
    EXPECT_NE(message.find(word), std::string::npos) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

TEST(Calibration, ReportsCameraWithTooFewViews) {
  Scene scene;
  std::map<int, BoardView>& views = scene.views[2].views;
  while (views.size() > 5) views.erase(views.begin());
  const std::string message = messageOf([&] { scene.calibrated(); });
  EXPECT_NE(message.find("\"cam2\" sees the board well in 5 frames"), std::string::npos) << message;
  scene.views.resize(1);
  EXPECT_NE(messageOf([&] { scene.calibrated(); }).find("1 camera cannot"), std::string::npos);
}

TEST(Calibration, RejectsInconsistentCorners) {
  Scene scene;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(0, 639), v(0, 479);
  for (auto& [frame, view] : scene.views[1].views)
    for (Vec2& pixel : view.pixels) pixel = Vec2(u(random), v(random));
  EXPECT_NE(messageOf([&] { scene.calibrated(); }).find("\"cam1\""), std::string::npos);
}

TEST(Calibration, FindsEveryLensModel) {
  const std::array<double, 8> five = {-0.338, 0.0967, -1.35e-3, 3.16e-3, -3.7e-3};
  const std::array<double, 8> eight = {0.4, 0.05, 8e-4, -3e-4, 0.03, 0.6, 0.02, 0.01};
  const std::array<double, 8> fish = {-0.03, 0.012, -0.008, 0.0015};
  struct Case {
    LensChoice choice;
    Lens lens;
  };
  for (const Case& tried : {Case{LensChoice::kFive, lensOf(LensModel::kPerspective, 500, five)},
                            Case{LensChoice::kAuto, lensOf(LensModel::kPerspective, 500, five)},
                            Case{LensChoice::kEight, lensOf(LensModel::kPerspective, 500, eight)},
                            Case{LensChoice::kFisheye, lensOf(LensModel::kFisheye, 420, fish)},
                            Case{LensChoice::kAuto, lensOf(LensModel::kFisheye, 420, fish)}}) {
    SCOPED_TRACE(tried.lens.fx);
    const Scene scene({}, tried.lens);
    CalibrationOptions options;
    options.lens = tried.choice;
    const Calibration found = scene.calibrated(options);
    expectAccurate(scene.rig, found.rig);
    EXPECT_LE(found.rms_px, 0.35);
    for (const Camera& camera : found.rig.cameras) {
      const std::array<double, 8>& k = camera.lens.distortion;
      if (tried.choice != LensChoice::kAuto) {
        EXPECT_EQ(camera.lens.model, tried.lens.model);
      }
      if (tried.choice == LensChoice::kFive) {
        EXPECT_TRUE(k[4] != 0 && k[5] == 0);
      }
      if (tried.choice == LensChoice::kEight) {
        EXPECT_TRUE(k[5] != 0 && k[7] != 0);
      }
    }
  }
}

TEST(Calibration, UndistortedLensGetsFewCoefficients) {
  const Scene scene({}, lensOf(LensModel::kPerspective, 560, {}));
  for (const Camera& camera : scene.calibrated().rig.cameras) {
    EXPECT_EQ(camera.lens.model, LensModel::kPerspective);
    EXPECT_LE(std::count_if(camera.lens.distortion.begin(), camera.lens.distortion.end(),
                            [](double k) { return k != 0; }),
              2);
  }
}

TEST(Calibration, ChosenBoardDefinesTheWorld) {
  const Scene scene;
  CalibrationOptions options;
  options.world_frame = 17;
  const Calibration found = scene.calibrated(options);
  EXPECT_EQ(found.world_frame, 17);
  // Without --center, the workspace is above the board.
  EXPECT_EQ(found.rig.workspace.center, Vec3(0, 0, 0.3));
  const Vec3 middle = 0.5 * scene.board.square_m * Vec3(7, 5, 0);
  for (std::size_t i = 0; i < 4; ++i) {
    const Pose camera_from_board = scene.rig.cameras[i].camera_from_world * scene.boards[17];
    // The board's middle is the origin; 10 cm along its rows is x; 10 cm out of its front is z.
    const Pose& camera_from_world = found.rig.cameras[i].camera_from_world;
    EXPECT_LE((camera_from_world * Vec3(0, 0, 0) - camera_from_board * middle).norm(), 2e-3);
    EXPECT_LE((camera_from_world * Vec3(0.1, 0, 0) - camera_from_board * (middle + Vec3(0.1, 0, 0))).norm(),
              2e-3);
    EXPECT_LE((camera_from_world * Vec3(0, 0, 0.1) - camera_from_board * (middle - Vec3(0, 0, 0.1))).norm(),
              2e-3);
  }
  options.center = Vec3(0.1, -0.2, 0.3);
  options.edge_m = 0.5;
  const Rig placed = scene.calibrated(options).rig;
  EXPECT_EQ(placed.workspace.center, *options.center);
  EXPECT_EQ(placed.workspace.edge_m, 0.5);
  options.world_frame = 1000;
  EXPECT_NE(messageOf([&] { scene.calibrated(options); }).find("--world 1000"), std::string::npos);
}

TEST(Calibration, ReportsCameraThatAgreesWithNoOther) {
  Scene scene;
  std::map<int, BoardView>& views = scene.views[3].views;
  std::vector<BoardView> shuffled;  // its frames in a different order
  for (const auto& [frame, view] : views) shuffled.push_back(view);
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(5));
  std::size_t next = 0;
  for (auto& [frame, view] : views) view = shuffled[next++];
  EXPECT_NE(messageOf([&] { scene.calibrated(); }).find("\"cam3\""), std::string::npos);
}

TEST(Calibration, ReportsUnsynchronizedCameras) {
  Scene scene;
  // Camera 3 is one frame late in every third frame: the board has moved by then.
  std::map<int, BoardView>& views = scene.views[3].views;
  const std::map<int, BoardView> punctual = views;
  for (auto& [frame, view] : views)
    if (frame % 3 == 0 && punctual.contains(frame + 1)) view = punctual.at(frame + 1);
  const Calibration found = scene.calibrated();
  EXPECT_TRUE(anyMentions(found.warnings, "at the same time"));
  expectAccurate(scene.rig, found.rig);
}

/// Rendered images in folders, through the detector.
class RecordingTest : public testing::Test {
 protected:
  void draw(const Scene& scene, int frames) {
    drawImages(folder.path(), scene.rig, scene.board, {scene.boards.begin(), scene.boards.begin() + frames});
  }
  TemporaryFolder folder;
};

TEST_F(RecordingTest, RenderedImagesGiveTheRig) {
  const Scene scene;
  draw(scene, scene.wave.frames);
  BoardRecording recording(folder.path());
  EXPECT_EQ(recording.frameCount(), scene.wave.frames);
  EXPECT_TRUE(recording.notes().empty());
  const std::vector<CameraViews> views = recording.findBoards(BoardDetector(scene.board));
  ASSERT_EQ(views.size(), 4u);
  const Calibration found = calibrate(scene.board, views);
  expectAccurate(scene.rig, found.rig);
  EXPECT_LE(found.rms_px, 0.35);

  drawCalibration(folder / "rig.png", scene.board, found);
  const cv::Mat image = cv::imread((folder / "rig.png").string());
  EXPECT_EQ(image.cols, 3 * 496 + 16);

  Board other = scene.board;
  other.dictionary = "6X6_250";
  const std::string message = messageOf([&] { recording.findBoards(BoardDetector(other)); });
  for (const char* word : {"6X6_250", "4X4_50", "--dictionary"})
    EXPECT_NE(message.find(word), std::string::npos) << message;
}

/// The a3Board() in front of two cameras that are 1.1 m away, scaled so that its markers are about
/// `marker_px` wide.
struct SmallBoardScene {
  Rig rig = ringRig(4, 640, 480);
  Board board = a3Board();
  std::vector<Pose> boards;

  SmallBoardScene(double marker_px, int frames) {
    rig.cameras.resize(2);
    const Camera& camera = rig.cameras[0];
    const double distance_m = (camera.camera_from_world * rig.workspace.center).z();
    board.marker_m = marker_px * distance_m / camera.lens.fx;
    board.square_m = board.marker_m * 55 / 41;
    Wave wave;
    wave.frames = frames;
    boards = wavedBoards(rig, board, wave);
  }
};

void expectTooSmall(const std::string& message) {
  for (const char* part : {"camera \"cam", "too small in the image", "markers measure", "at least 18 px"})
    EXPECT_NE(message.find(part), std::string::npos) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

TEST_F(RecordingTest, ReportsBoardThatIsTooSmall) {
  for (const double marker_px : {14.0, 7.0}) {
    const SmallBoardScene scene(marker_px, 12);
    const TemporaryFolder small;
    drawImages(small.path(), scene.rig, scene.board, scene.boards);
    BoardRecording recording(small.path());
    expectTooSmall(
        messageOf([&] { calibrate(scene.board, recording.findBoards(BoardDetector(scene.board))); }));
  }
}

/// Too small a board yields inaccurate corners, so that no two cameras agree.
TEST(Calibration, ReportsSmallBoardInsteadOfDisagreement) {
  Scene scene;
  for (CameraViews& camera : scene.views)
    for (auto& [frame, view] : camera.views)
      for (Vec2& pixel : view.pixels) pixel *= 0.6;
  while (scene.views[2].views.size() > 5) scene.views[2].views.erase(scene.views[2].views.begin());
  expectTooSmall(messageOf([&] { scene.calibrated(); }));
}

TEST_F(RecordingTest, ProgramWritesTheRig) {
  Wave wave;
  wave.frames = 32;
  const Scene scene(wave);
  draw(scene, wave.frames);
  const std::string rig = folder / "rig.toml", image = folder / "rig.png";
  const std::vector<std::string> board = {"--squares", "7x5", "--square-mm", "55", "--marker-mm", "41"};
  const auto run = [&](std::vector<std::string> arguments, const RunOptions& options = {}) {
    arguments.insert(arguments.begin(), {"calibrate", folder.path().string(), "--out", rig});
    arguments.insert(arguments.end(), board.begin(), board.end());
    return runAirclay(arguments, options);
  };
  const RunResult result = run({"--json", "--image", image, "--world", "3", "--center", "0,0,0"});
  ASSERT_EQ(result.status, 0) << result.errors;
  const nlohmann::json figures = nlohmann::json::parse(result.output);
  EXPECT_LE(figures.at("rms_px").get<double>(), 0.35);
  EXPECT_LE(figures.at("scale_error_mm").get<double>(), 0.5);
  ASSERT_EQ(figures.at("cameras").size(), 4u);
  EXPECT_EQ(figures["cameras"][3].at("name"), "cam3");
  EXPECT_GE(figures["cameras"][3].at("views").get<int>(), kFewestViews);
  EXPECT_TRUE(figures.at("warnings").is_array());
  EXPECT_FALSE(cv::imread(image).empty());
  const Rig found = readRig(rig);
  const CubeError error = cubeError(scene.rig, found);
  EXPECT_LE(error.central_mm, 0.12);
  EXPECT_LE(error.whole_mm, 0.7);

  // Printed too small: the rig uses the measured size, and a message says so.
  const RunResult measured = run({"--check-square-mm", "53.9"});
  EXPECT_EQ(measured.status, 0);
  EXPECT_NE(measured.errors.find("98.0 %"), std::string::npos) << measured.errors;
  EXPECT_NEAR(cubeError(scene.rig, readRig(rig)).scale, 53.9 / 55, 1e-3);
  EXPECT_EQ(run({"--check-square-mm", "5.5"}).status, 2);

  std::filesystem::remove(rig);
  const RunResult wrong = run({"--dictionary", "6X6_250"});
  EXPECT_EQ(wrong.status, 1);
  EXPECT_EQ(wrong.errorLines().size(), 1u) << wrong.errors;
  EXPECT_NE(wrong.errors.find("4X4_50"), std::string::npos) << wrong.errors;
  RunOptions hasty;
  hasty.terminate_after_ms = 200;
  EXPECT_EQ(run({}, hasty).status, 128 + SIGTERM);
  EXPECT_FALSE(std::filesystem::exists(rig));
}

/// The hand in the cameras of a rig, tracked as if they were those of `believed`.
class Follower {
 public:
  explicit Follower(const Rig& believed) : pipeline_(testGpu(), believed, builtInHand(false)) {
    for (std::size_t c = 0; c < believed.cameras.size(); ++c) images.push_back(pipeline_.image(c));
  }
  void learn() { pipeline_.learnBackground(); }
  void follow(const Pose& truth) {
    const FrameResult result = pipeline_.trackImages();
    EXPECT_EQ(result.state(), HandState::kTracked);
    errors_mm.push_back(1000 *
                        poseError(result.trackedHand()->pose.world_from_hand, truth, Vec3::Zero()).shift_m);
  }

  std::vector<std::span<std::uint8_t>> images;  ///< buffers for the next ones
  std::vector<double> errors_mm;                ///< of the hand's position, per frame

 private:
  Pipeline pipeline_;
};

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2), values.end());
  return values[values.size() / 2];
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

// The effect of calibration errors: tracking is as accurate as with exactly known cameras.
TEST_F(RecordingTest, RecoveredRigTracksLikeTheTrueOne) {
  SyntheticOptions options;
  options.script = smallTakeScript();
  const Rig& truth = options.rig;
  const Board board = a3Board();
  drawVideos(folder.path(), truth, board, wavedBoards(truth, board, {}));
  BoardRecording recording(folder.path());
  const Calibration found = calibrate(board, recording.findBoards(BoardDetector(board)));
  Rig recovered;  // in the true rig's order
  for (const Camera& camera : truth.cameras)
    recovered.cameras.push_back(
        *std::find_if(found.rig.cameras.begin(), found.rig.cameras.end(),
                      [&](const Camera& other) { return other.name == camera.name; }));
  const CubeError error = cubeError(truth, recovered);
  Synthetic take(testGpu(), options);
  Follower with_truth(truth), with_recovered(alignedTo(truth, recovered));
  for (int frame = 0; frame < take.backgroundFrames() + 20; ++frame) {
    ASSERT_TRUE(take.readImages(frame, with_truth.images));
    for (std::size_t c = 0; c < with_truth.images.size(); ++c)
      std::copy(with_truth.images[c].begin(), with_truth.images[c].end(), with_recovered.images[c].begin());
    const int seen = frame - take.backgroundFrames();
    for (Follower* follower : {&with_truth, &with_recovered})
      if (seen < 0)
        follower->learn();
      else
        follower->follow(take.truth()->at(std::size_t(seen)).world_from_hand);
  }
  std::cout << "corners " << found.rms_px << " px RMS; cube " << error.central_mm << " mm, whole "
            << error.whole_mm << " mm\nthe hand is off by " << median(with_truth.errors_mm) << " mm (mean "
            << mean(with_truth.errors_mm) << ") with the true rig, by " << median(with_recovered.errors_mm)
            << " mm (mean " << mean(with_recovered.errors_mm) << ") with the recovered one\n";
  EXPECT_LE(median(with_recovered.errors_mm) - median(with_truth.errors_mm), 0.2);
  EXPECT_LE(mean(with_recovered.errors_mm) - mean(with_truth.errors_mm), 0.2);
}

TEST_F(RecordingTest, TimestampsMatchFrames) {
  Scene scene;
  scene.rig.cameras.resize(2);
  draw(scene, 6);
  // Camera 1 missed the third instant: its frame 2 is instant 3. All except the last of its rows are used.
  std::string rows = "cam_id,frame_time\n";
  for (int frame = 0; frame < 6; ++frame)
    rows += "0," + std::to_string(0.1 * frame) + "\n1," +
            std::to_string(0.1 * (frame + (frame >= 2)) + 0.02) + "\n";
  folder.write("timestamps.csv", rows);
  BoardRecording recording(folder.path());
  const BoardDetector detector(scene.board);
  const std::vector<CameraViews> views = recording.findBoards(detector);
  EXPECT_FALSE(views[1].views.contains(2));
  for (const auto& [instant, view] : views[1].views) {
    const int frame = instant < 2 ? instant : instant - 1;
    const BoardView truth = trueView(scene.board, scene.rig.cameras[1], scene.boards[std::size_t(frame)]);
    for (std::size_t i = 0; i < view.ids.size(); ++i) {
      const auto id = std::find(truth.ids.begin(), truth.ids.end(), view.ids[i]);
      ASSERT_NE(id, truth.ids.end());
      EXPECT_LE((truth.pixels[std::size_t(id - truth.ids.begin())] - view.pixels[i]).norm(), 0.5);
    }
  }
}

TEST_F(RecordingTest, RejectsOtherFolders) {
  EXPECT_NE(messageOf([&] { BoardRecording(folder / "none"); }).find("none"), std::string::npos);
  EXPECT_NE(messageOf([&] { BoardRecording(folder.path()); }).find("0 cameras"), std::string::npos);
  folder.write("left.mp4", "no video");
  EXPECT_NE(messageOf([&] { BoardRecording(folder.path()); }).find("1 camera;"), std::string::npos);
  folder.write("right.mp4", "no video");
  EXPECT_NE(messageOf([&] { BoardRecording(folder.path()); }).find("left.mp4"), std::string::npos);
}

}  // namespace
}  // namespace airclay
