// SPDX-License-Identifier: MIT
// Collecting views of a moving board, on rendered images with known corners.
#include "capture/calibration/board_collector.h"
#include "capture/calibration/board_detector.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/support/board_scene.h"
#include "tests/support/scene.h"

namespace airclay {
namespace {

constexpr ImageSize kSize = {320, 240};

/// Two cameras half a metre apart, aimed at the same point a metre away.
struct Stage {
  Board board;
  Rig rig = ringRig(12, kSize.width, kSize.height);

  Stage() {
    board.square_m = 0.06;
    board.marker_m = 0.045;
    rig.cameras.resize(2);
  }
  BoardCollector collector(const BoardCollector::Options& options = {}) const {
    return BoardCollector(board, {{rig.cameras[0].name, kSize}, {rig.cameras[1].name, kSize}}, options);
  }
  LiveSet set(const Pose& world_from_board, double time_s, const BoardShot& shot = {}) const {
    LiveSet result;
    for (const Camera& camera : rig.cameras) {
      result.images.push_back({kSize, drawBoard(board, camera, world_from_board, shot)});
      result.camera_times_s.push_back(time_s);
    }
    result.time_s = time_s;
    result.complete = true;
    return result;
  }
  Pose before(std::size_t camera, const Vec3& turn = Vec3::Zero(),
              const Vec3& offset_m = Vec3::Zero()) const {
    return boardBefore(board, rig.cameras[camera], 0.75, turn, offset_m);
  }
};

/// The exposure of the board that the detector finds; empty if it finds none.
std::optional<BoardExposure> exposureIn(const Board& board, const std::vector<std::uint8_t>& bgr) {
  const auto view = BoardDetector(board).find(kSize, PixelFormat::kBgr8, bgr);
  return view ? view->exposure : std::nullopt;
}

TEST(BoardExposure, MeasuresBlurAndLight) {
  const Stage stage;
  // at this distance a square has 50 pixels
  Camera camera = stage.rig.cameras[0];
  Board board = stage.board;
  board.marker_m = 0.035;  // a wide margin around the markers
  for (const double blur_px : {0.0, 0.6, 1.0, 1.5})
    for (const double turn : {0.0, 0.3}) {
      BoardShot shot;
      shot.blur_px = blur_px;
      shot.black = 40;
      shot.white = 180;
      shot.noise_sigma = 2;
      const Pose pose = boardBefore(board, camera, 0.45, Vec3(turn, 0.5 * turn, turn));
      const std::vector<std::uint8_t> bgr = drawBoard(board, camera, pose, shot);
      const auto light = exposureIn(board, bgr);
      ASSERT_TRUE(light) << blur_px;
      // the pixel's own square has a standard deviation of 1 / sqrt(12)
      EXPECT_NEAR(light->blur_px, std::hypot(blur_px, std::sqrt(1.0 / 12)), 0.2) << blur_px << " " << turn;
      EXPECT_NEAR(light->black, 40, 4) << blur_px;
      EXPECT_NEAR(light->white, 180, 4) << blur_px;
    }
}

TEST(BoardExposure, BrightnessDoesNotDependOnTilt) {
  const Stage stage;
  const Camera& camera = stage.rig.cameras[0];
  for (const double turn : {0.0, 0.6, 0.9, 1.1}) {
    const Pose pose = boardBefore(stage.board, camera, 0.45, Vec3(0, turn, 0));
    const auto light = exposureIn(stage.board, drawBoard(stage.board, camera, pose));
    if (!light) continue;  // too narrow to measure
    EXPECT_GT(light->white, 200) << turn;
    EXPECT_LT(light->black, 50) << turn;
  }
}

TEST(BoardExposure, UniformGreyHasNoExposure) {
  const Stage stage;
  const std::vector<std::uint8_t> grey(std::size_t(3) * 320 * 240, 128);
  EXPECT_FALSE(exposureIn(stage.board, grey));
}

TEST(BoardCollector, KeepsARestingBoardOnce) {
  const Stage stage;
  BoardCollector collector = stage.collector();
  EXPECT_FALSE(collector.add(stage.set(stage.before(0), 0)))
      << "the first frame cannot show that the board rests";
  EXPECT_TRUE(collector.add(stage.set(stage.before(0), 1.0 / 30)));
  EXPECT_FALSE(collector.add(stage.set(stage.before(0), 2.0 / 30))) << "the view is redundant";
  // 4 cm in a thirtieth of a second: about 10 pixels
  const Pose there = stage.before(0, Vec3::Zero(), Vec3(0.04, 0.02, 0));
  EXPECT_FALSE(collector.add(stage.set(there, 3.0 / 30)));
  EXPECT_TRUE(collector.add(stage.set(there, 4.0 / 30)));
  EXPECT_EQ(collector.selectedSets(), 2);
  EXPECT_EQ(collector.cameras()[0].views, 2);
  EXPECT_EQ(collector.views()[0].views.size(), 2u);
  const BoardView& view = collector.views()[0].views.begin()->second;
  const BoardView truth = trueView(stage.board, stage.rig.cameras[0], stage.before(0));
  ASSERT_EQ(view.ids, truth.ids);
  for (std::size_t i = 0; i < view.ids.size(); ++i) EXPECT_LT((view.pixels[i] - truth.pixels[i]).norm(), 0.1);
  collector.clear();
  EXPECT_EQ(collector.selectedSets(), 0);
  EXPECT_TRUE(collector.views()[0].views.empty());
  EXPECT_EQ(collector.cameras()[0].coverage.fraction(), 0);
}

TEST(BoardCollector, UnsynchronizedCamerasNeedAStillerBoard) {
  const Stage stage;
  // 3 mm per frame, about 0.9 pixels: 27 per second
  const auto slide = [&](BoardCollector collector, double skew_s) {
    int count = 0;
    for (int i = 0; i < 40; ++i) {
      LiveSet set = stage.set(stage.before(0, Vec3::Zero(), Vec3(-0.06 + 0.003 * i, 0, 0)), i / 30.0);
      set.skew_s = skew_s;
      count += collector.add(set);
    }
    return count;
  };
  EXPECT_GE(slide(stage.collector(), 0), 2);
  EXPECT_EQ(slide(stage.collector(), 0.03), 0);
  BoardCollector::Options arrivals;
  arrivals.unseen_skew_s = 0.03;
  EXPECT_EQ(slide(stage.collector(arrivals), 0), 0);
}

TEST(BoardCollector, AdviceNamesMissingViews) {
  const Stage stage;
  BoardCollector collector = stage.collector();
  LiveSet empty = stage.set(stage.before(0, Vec3(0, M_PI, 0), Vec3(0, 0, 3)), 0);
  double time_s = 0;
  const auto show = [&](const Pose& pose, const BoardShot& shot = {}) {
    for (int i = 0; i < 2; ++i) collector.add(stage.set(pose, time_s += 1.0 / 30, shot));
  };
  collector.add(empty);
  EXPECT_EQ(collector.advice(), "no camera sees the board; hold it in the workspace");
  BoardShot dark;
  dark.black = 5;
  dark.white = 60;
  dark.background = 20;
  for (const Camera& camera : stage.rig.cameras) show(boardBefore(stage.board, camera, 0.5), dark);
  EXPECT_NE(collector.advice().find("the board is too dark for cam"), std::string::npos)
      << collector.advice();

  double last = 0;
  std::set<std::string> advice;
  for (int i = 0; i < 400 && !collector.enough(); ++i) {
    // a path through the workspace that tilts the board in all directions
    const double a = 0.37 * i, b = 0.23 * i;
    const Vec3 turn(0.5 * std::sin(a), 0.5 * std::cos(b), 0.3 * std::sin(b));
    const Vec3 place(0.16 * std::sin(b), 0.12 * std::cos(a), 0.1 * std::sin(0.5 * a));
    show(stage.before(i % 2, turn, place));
    EXPECT_GE(collector.progress(), last) << "progress decreases";
    last = collector.progress();
    advice.insert(collector.advice());
  }
  EXPECT_TRUE(collector.enough()) << collector.advice();
  EXPECT_EQ(collector.progress(), 1);
  EXPECT_EQ(collector.advice(), "enough views");
  EXPECT_GE(advice.size(), 2u) << "the advice never changes";
  for (const CollectedCamera& camera : collector.cameras()) {
    EXPECT_GE(camera.views, kFewViews);
    EXPECT_GE(camera.shared_views, kFewShared);
    EXPECT_GE(camera.coverage.fraction(), kPoorCoverage);
  }
  const Calibration found = calibrate(stage.board, collector.views());
  EXPECT_LT(found.rms_px, 0.1);
}

TEST(BoardCollector, KeepsTheWorldBoardEvenIfRedundant) {
  const Stage stage;
  BoardCollector collector = stage.collector();
  EXPECT_FALSE(collector.selectForWorld());
  collector.add(stage.set(stage.before(0), 0));
  const auto number = collector.selectForWorld();
  ASSERT_TRUE(number);
  EXPECT_EQ(collector.views()[0].views.count(*number), 1u);
  EXPECT_EQ(collector.selectForWorld(), number);
  EXPECT_EQ(collector.selectedSets(), 1) << "once";
}

TEST(BoardCollector, SkipsCamerasWithoutAnImage) {
  const Stage stage;
  BoardCollector collector = stage.collector();
  for (int i = 0; i < 2; ++i) {
    LiveSet set = stage.set(stage.before(0), i / 30.0);
    set.images[1] = {};
    collector.add(set);
  }
  EXPECT_EQ(collector.cameras()[0].views, 1);
  EXPECT_EQ(collector.cameras()[0].shared_views, 0);
  EXPECT_EQ(collector.cameras()[1].views, 0);
}

}  // namespace
}  // namespace airclay
