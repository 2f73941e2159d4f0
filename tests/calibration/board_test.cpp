// SPDX-License-Identifier: MIT
// Boards compared with OpenCV's drawing, and detected corners compared with their true positions.
#include "capture/calibration/board.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/aruco/charuco.hpp>
#include <thread>

#include "capture/calibration/board_advice.h"
#include "capture/calibration/board_detector.h"
#include "capture/calibration/board_pattern.h"
#include "engine/core/error.h"
#include "tests/support/board_scene.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

constexpr double kPi = std::numbers::pi;

Board charuco(int squares_x, int squares_y, double square_m, double marker_m) {
  Board board;
  board.squares_x = squares_x, board.squares_y = squares_y;
  board.square_m = square_m, board.marker_m = marker_m;
  return board;
}
Board a3Board() {
  return charuco(7, 5, 0.055, 0.041);
}
Board chessboard(int squares_x, int squares_y) {
  Board board = charuco(squares_x, squares_y, 0.025, 0);
  board.chessboard = true;
  return board;
}

Camera webcam() {
  Camera camera;
  camera.name = "webcam";
  camera.width = 640, camera.height = 480;
  camera.lens.fx = 560, camera.lens.fy = 563, camera.lens.cx = 321.3, camera.lens.cy = 236.8;
  camera.lens.distortion = {-0.2, 0.06, 1e-3, -5e-4, 0};
  camera.lens = withMonotonicRange(camera.lens);
  camera.camera_from_world.linear() = rotationFromVector({0.3, -1.1, 0.4});
  camera.camera_from_world.translation() = Vec3(0.1, 0.2, 1.3);
  return camera;
}

std::optional<BoardView> look(const Board& as, const Camera& camera, std::span<const std::uint8_t> image) {
  return BoardDetector(as).find({camera.width, camera.height}, PixelFormat::kBgr8, image);
}

/// The errors of the found corners in pixels.
struct Errors {
  int corners = 0, expected = 0;
  Vec2 bias = Vec2::Zero();
  double rms = 0, largest = 0;
};

/// Adds one image; a corner that the board lacks, or that is outside the image, is a failure.
void compare(const BoardView& found, const BoardView& truth, Errors& errors) {
  ASSERT_TRUE(std::is_sorted(found.ids.begin(), found.ids.end()));
  for (std::size_t i = 0; i < found.ids.size(); ++i) {
    const auto place = std::find(truth.ids.begin(), truth.ids.end(), found.ids[i]);
    ASSERT_NE(place, truth.ids.end()) << "corner " << found.ids[i] << " is not in the image";
    const Vec2 off = found.pixels[i] - truth.pixels[static_cast<std::size_t>(place - truth.ids.begin())];
    ++errors.corners;
    errors.bias += off;
    errors.rms += off.squaredNorm();
    errors.largest = std::max(errors.largest, off.norm());
  }
}

/// Boards at `distance_m`, tilted by up to `tilt` radians and rotated arbitrarily, all over the image.
Errors errorsOver(const Board& board, double distance_m, const BoardShot& shot, double tilt = 0.7) {
  const Camera camera = webcam();
  const BoardDetector detector(board);
  Errors errors;
  for (int i = 0; i < 24; ++i) {
    const double a = 2.4 * i, fraction = (i + 0.5) / 24;  // the golden angle: evenly distributed over a disc
    const Vec3 turn(tilt * std::sqrt(fraction) * std::cos(a), tilt * std::sqrt(fraction) * std::sin(a),
                    board.chessboard ? 0.4 * std::sin(a) : a);
    const double reach = board.chessboard ? 0.1 : 0.22;
    const Vec3 offset = distance_m * reach * std::sqrt(fraction) * Vec3(std::cos(3 * a), std::sin(3 * a), 0);
    const Pose pose = boardBefore(board, camera, distance_m, turn, offset);
    BoardShot here = shot;
    here.seed = static_cast<std::uint32_t>(i + 1);
    const std::vector<std::uint8_t> image = drawBoard(board, camera, pose, here);
    const std::optional<BoardView> view =
        detector.find({camera.width, camera.height}, PixelFormat::kBgr8, image);
    EXPECT_TRUE(view) << "image " << i;
    errors.expected += static_cast<int>(trueView(board, camera, pose, 8).ids.size());
    if (view) compare(*view, trueView(board, camera, pose), errors);
  }
  errors.bias /= errors.corners;
  errors.rms = std::sqrt(errors.rms / errors.corners);
  return errors;
}

void expectWithin(const Errors& errors, double bias_px, double rms_px, double largest_px) {
  EXPECT_GE(errors.corners, 0.97 * errors.expected);
  EXPECT_LE(errors.bias.cwiseAbs().maxCoeff(), bias_px) << errors.bias.transpose();
  EXPECT_LE(errors.rms, rms_px);
  EXPECT_LE(errors.largest, largest_px);
}

TEST(Board, PatternEqualsOpenCv) {
  struct Form {
    int x, y;
    const char* name;
    int opencv, cells;
  };
  for (const Form& form : {Form{5, 3, "4X4_50", cv::aruco::DICT_4X4_50, 6},
                           {7, 5, "4X4_1000", cv::aruco::DICT_4X4_1000, 6},
                           {4, 5, "5X5_100", cv::aruco::DICT_5X5_100, 7},
                           {6, 4, "6X6_250", cv::aruco::DICT_6X6_250, 8},
                           {3, 6, "7X7_50", cv::aruco::DICT_7X7_50, 9},
                           {6, 6, "ARUCO_ORIGINAL", cv::aruco::DICT_ARUCO_ORIGINAL, 7}}) {
    SCOPED_TRACE(form.name);
    const int cell = 4, marker = cell * form.cells, square = marker + 2 * cell;  // pixels
    const auto theirs = cv::aruco::CharucoBoard::create(form.x, form.y, float(square), float(marker),
                                                        cv::aruco::getPredefinedDictionary(form.opencv));
    cv::Mat1b drawn;
    theirs->draw({square * form.x, square * form.y}, drawn);

    Board board = charuco(form.x, form.y, 1e-3 * square, 1e-3 * marker);
    board.dictionary = form.name;
    const BoardPattern pattern(board);
    board.inverted = true;
    const BoardPattern inverted(board);
    cv::Mat1b painted(drawn.size(), 255), painted_inverted(drawn.size(), 255);
    for (const auto& [of, on] : {std::pair{&pattern, &painted}, {&inverted, &painted_inverted}})
      for (const BoardRectangle& r : of->rectangles()) {
        const auto px = [](double m) { return static_cast<int>(std::lround(1e3 * m)); };
        (*on)(cv::Range(px(r.top), px(r.bottom)), cv::Range(px(r.left), px(r.right))) = r.black ? 0 : 255;
      }
    int different = 0, black = 0;
    for (int y = 0; y < drawn.rows; ++y)
      for (int x = 0; x < drawn.cols; ++x) {
        const bool is_black = drawn(y, x) < 128;
        const Vec2 point_m = 1e-3 * Vec2(x + 0.5, y + 0.5);
        black += is_black;
        different += pattern.isBlack(point_m) != is_black || inverted.isBlack(point_m) == is_black ||
                     (painted(y, x) < 128) != is_black || (painted_inverted(y, x) < 128) == is_black;
      }
    EXPECT_EQ(different, 0);
    EXPECT_GT(black, drawn.total() / 2);
    // Their corners are numbered in the same order.
    for (int id = 0; id < board.cornerCount(); ++id) {
      const cv::Point3f& corner = theirs->chessboardCorners[static_cast<std::size_t>(id)];
      EXPECT_LE((1e3 * board.corner(id) - Vec3(corner.x, corner.y, corner.z)).norm(), 1e-4) << id;
    }
  }
}

TEST(Board, RejectsInvalidBoards) {
  const auto refused = [](auto change) {
    Board board;
    change(board);
    return messageOf([&] { checkBoard(board); });
  };
  EXPECT_EQ(refused([](Board&) {}), "");
  EXPECT_EQ(refused([](Board& b) { b.squares_x = 40, b.squares_y = 40, b.dictionary = "4X4_1000"; }), "");
  EXPECT_EQ(
      refused([](Board& b) { b.chessboard = true, b.squares_y = 4, b.dictionary = "", b.marker_m = 0; }), "");
  const auto expect = [&](const std::string& text, auto change) {
    EXPECT_NE(refused(change).find(text), std::string::npos) << text << ": " << refused(change);
  };
  expect("--squares 2x3", [](Board& b) { b.squares_x = 2; });
  expect("--squares 41x3", [](Board& b) { b.squares_x = 41; });
  expect("--squares 5x3", [](Board& b) { b.chessboard = true; });
  expect("--square-mm 0", [](Board& b) { b.square_m = 0; });
  expect("--square-mm nan", [](Board& b) { b.square_m = std::nan(""); });
  expect("--square-mm 2001", [](Board& b) { b.square_m = 2.001; });
  expect("--marker-mm -1", [](Board& b) { b.marker_m = -0.001; });
  expect("--marker-mm 54", [](Board& b) { b.marker_m = 0.054; });
  expect("--dictionary 4X4_49", [](Board& b) { b.dictionary = "4X4_49"; });
  expect("--dictionary 4X4_50 has 50", [](Board& b) { b.squares_x = 11, b.squares_y = 10; });
  expect("--two-sided", [](Board& b) { b.chessboard = b.two_sided = true, b.squares_y = 4; });
}

// The paper's distance: cells of 3.4 pixels.
TEST(BoardDetector, FindsCornersAtArmsLength) {
  expectWithin(errorsOver(Board(), 1.1, {}), 0.005, 0.02, 0.08);
  expectWithin(errorsOver(Board(), 1.1, {.noise_sigma = 2.5, .blur_px = 0.6}), 0.006, 0.03, 0.12);
}

TEST(BoardDetector, FindsCornersNearAndFar) {
  expectWithin(errorsOver(a3Board(), 0.75, {.noise_sigma = 2.5, .blur_px = 0.6}), 0.005, 0.025, 0.12);
  expectWithin(errorsOver(a3Board(), 1.3, {.noise_sigma = 2.5, .blur_px = 0.6}), 0.005, 0.03, 0.15);
  expectWithin(errorsOver(a3Board(), 1.1, {.noise_sigma = 2.5, .blur_px = 1}), 0.006, 0.04, 0.2);
}

TEST(BoardDetector, FindsCornersInPoorLight) {
  BoardShot dim{.noise_sigma = 4, .blur_px = 0.7, .black = 25, .white = 75, .background = 40};
  expectWithin(errorsOver(a3Board(), 1.0, dim), 0.02, 0.1, 0.5);
}

TEST(BoardDetector, FindsCornersOfAnInvertedBoard) {
  Board board = a3Board();
  board.inverted = true;
  expectWithin(errorsOver(board, 1.0, {.noise_sigma = 2.5, .blur_px = 0.6}), 0.005, 0.03, 0.15);
}

TEST(BoardDetector, FindsCornersOfAChessboard) {
  expectWithin(errorsOver(chessboard(10, 7), 0.55, {.noise_sigma = 2.5, .blur_px = 0.6}, 0.5), 0.005, 0.025,
               0.12);
}

TEST(BoardDetector, UpsideDownBoardKeepsCornerNumbers) {
  const Camera camera = webcam();
  for (Board board : {Board(), a3Board(), chessboard(10, 7), chessboard(7, 10)})
    for (const double turn : {0.0, kPi / 2, kPi, -kPi / 2}) {
      const double distance_m = board.chessboard ? 0.6 : 1.0;
      const Pose pose = boardBefore(board, camera, distance_m, Vec3(0, 0, turn));
      const auto view = look(board, camera, drawBoard(board, camera, pose, {.noise_sigma = 2}));
      ASSERT_TRUE(view) << turn;
      EXPECT_EQ(static_cast<int>(view->ids.size()), board.cornerCount());
      Errors errors;
      compare(*view, trueView(board, camera, pose), errors);
      EXPECT_LE(errors.largest, 0.15) << board.squares_x << " turned by " << turn;
    }
}

TEST(BoardDetector, AmbiguousChessboardRowsRunToTheRight) {
  const Camera camera = webcam();
  for (const Board& board : {chessboard(9, 7), chessboard(6, 6), chessboard(7, 7)}) {
    ASSERT_TRUE(board.isAmbiguous());
    for (const double turn : {0.3, 0.3 + kPi}) {
      const Pose pose = boardBefore(board, camera, 0.6, Vec3(0, 0, turn));
      const auto view = look(board, camera, drawBoard(board, camera, pose));
      ASSERT_TRUE(view);
      const Vec2 row = view->pixels[static_cast<std::size_t>(board.cornersX() - 1)] - view->pixels[0];
      EXPECT_GT(row.x(), 0);
      const Vec2 column = view->pixels[static_cast<std::size_t>(board.cornersX())] - view->pixels[0];
      EXPECT_GT(row.x() * column.y() - row.y() * column.x(), 0) << "mirrored";
    }
  }
}

TEST(BoardDetector, FindsTheVisiblePartOfABoard) {
  const Camera camera = webcam();
  const Board board = a3Board();
  for (const Vec3& offset : {Vec3(0.5, 0, 0), Vec3(-0.5, 0.1, 0), Vec3(0, 0.4, 0), Vec3(0.4, -0.3, 0)}) {
    const Pose pose = boardBefore(board, camera, 0.9, Vec3(0.2, 0.3, 0.1), offset);
    const BoardView truth = trueView(board, camera, pose), inner = trueView(board, camera, pose, 8);
    ASSERT_LT(static_cast<int>(truth.ids.size()), board.cornerCount());
    const auto view = look(board, camera, drawBoard(board, camera, pose, {.noise_sigma = 2.5}));
    ASSERT_TRUE(view) << offset.transpose();
    EXPECT_GE(view->ids.size() + 1, inner.ids.size());
    Errors errors;
    compare(*view, truth, errors);
    EXPECT_LE(errors.largest, 0.2) << offset.transpose();
  }
}

TEST(BoardDetector, OmitsCoveredCorners) {
  const Camera camera = webcam();
  const Board board = a3Board();
  const Pose pose = boardBefore(board, camera, 0.9, Vec3(0.2, -0.3, 0.1));
  std::vector<std::uint8_t> image = drawBoard(board, camera, pose, {.noise_sigma = 2.5});
  const BoardView truth = trueView(board, camera, pose);
  const Vec2 hand = truth.pixels[8];
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      if ((Vec2(x, y) - hand).norm() < 50)
        std::fill_n(&image[static_cast<std::size_t>(3 * (y * camera.width + x))], 3, std::uint8_t{150});
  const auto view = look(board, camera, image);
  ASSERT_TRUE(view);
  for (std::size_t i = 0; i < view->ids.size(); ++i)
    EXPECT_GT((view->pixels[i] - hand).norm(), 48) << view->ids[i];
  int uncovered = 0;
  for (const Vec2& pixel : truth.pixels) uncovered += (pixel - hand).norm() > 62;
  EXPECT_GE(static_cast<int>(view->ids.size()), uncovered);
  Errors errors;
  compare(*view, truth, errors);
  EXPECT_LE(errors.largest, 0.35);
}

TEST(BoardDetector, IgnoresOtherBoards) {
  const Camera camera = webcam();
  const auto findAs = [&](const Board& as, const Board& shown) {
    const Pose pose = boardBefore(shown, camera, 0.8, Vec3(0.2, 0.3, 0.1));
    return look(as, camera, drawBoard(shown, camera, pose, {.noise_sigma = 2.5})).has_value();
  };
  Board other_dictionary;
  other_dictionary.dictionary = "5X5_100";
  Board inverted;
  inverted.inverted = true;
  EXPECT_TRUE(findAs(Board(), Board()));
  EXPECT_FALSE(findAs(Board(), other_dictionary));
  EXPECT_FALSE(findAs(other_dictionary, Board()));
  EXPECT_FALSE(findAs(Board(), a3Board()));
  EXPECT_FALSE(findAs(a3Board(), Board()));
  EXPECT_FALSE(findAs(Board(), inverted));
  EXPECT_FALSE(findAs(inverted, Board()));
  EXPECT_FALSE(findAs(Board(), chessboard(10, 7)));
  EXPECT_FALSE(findAs(chessboard(10, 7), a3Board()));
  EXPECT_FALSE(findAs(chessboard(10, 7), chessboard(9, 7)));
}

TEST(BoardDetector, FindsNothingWithoutABoard) {
  const Camera camera = webcam();
  const Board board = a3Board();
  const Pose behind = boardBefore(board, camera, 0.9, Vec3(0, kPi, 0));
  EXPECT_FALSE(look(board, camera, drawBoard(board, camera, behind)));
  const Pose front = boardBefore(board, camera, 0.9);
  EXPECT_FALSE(look(board, camera, drawBoard(board, camera, front, {.blur_px = 8})));
  EXPECT_FALSE(look(board, camera, drawBoard(board, camera, front, {.black = 100, .white = 104})));
  EXPECT_FALSE(look(board, camera, std::vector<std::uint8_t>(640 * 480 * 3, 128)));
  EXPECT_FALSE(look(chessboard(10, 7), camera, std::vector<std::uint8_t>(640 * 480 * 3, 128)));
  const std::vector<std::uint8_t> one(3, 0);
  EXPECT_FALSE(BoardDetector(board).find({1, 1}, PixelFormat::kBgr8, one));
  EXPECT_FALSE(BoardDetector(chessboard(10, 7)).find({1, 1}, PixelFormat::kBgr8, one));
  EXPECT_NE(messageOf([&] { BoardDetector(board).find({2, 1}, PixelFormat::kBgr8, one); }), "");
}

TEST(BoardDetector, FindsTheBackOfATwoSidedBoard) {
  const Camera camera = webcam();
  Board board = a3Board();
  board.two_sided = true;
  for (const double turn : {0.0, kPi - 0.4}) {
    const Pose pose = boardBefore(board, camera, 0.9, Vec3(0, turn, 0));
    const auto view = look(board, camera, drawBoard(board, camera, pose, {.noise_sigma = 2.5}));
    ASSERT_TRUE(view) << turn;
    EXPECT_EQ(static_cast<int>(view->ids.size()), board.cornerCount());
    Errors errors;
    compare(*view, trueView(board, camera, pose), errors);
    EXPECT_LE(errors.largest, 0.15) << turn;
  }
}

TEST(BoardDetector, GreyImagesAndThreadsGiveEqualResults) {
  const Camera camera = webcam();
  const Board board = a3Board();
  const BoardDetector detector(board);
  const ImageSize size{camera.width, camera.height};
  const Pose pose = boardBefore(board, camera, 1.0, Vec3(0.3, 0.2, 0.1));
  const std::vector<std::uint8_t> bgr = drawBoard(board, camera, pose, {.noise_sigma = 2.5});
  std::vector<std::uint8_t> grey;
  for (std::size_t i = 0; i < bgr.size(); i += 3) grey.push_back(bgr[i]);
  const auto expected = detector.find(size, PixelFormat::kGrey8, grey);
  ASSERT_TRUE(expected);
  std::vector<std::optional<BoardView>> views(4);
  std::vector<std::thread> threads;
  for (auto& view : views) threads.emplace_back([&] { view = detector.find(size, PixelFormat::kBgr8, bgr); });
  for (std::thread& thread : threads) thread.join();
  for (const auto& view : views) {
    ASSERT_TRUE(view);
    EXPECT_EQ(view->ids, expected->ids);
    EXPECT_EQ(view->pixels, expected->pixels);
  }
}

TEST(BoardAdvice, CountsPixelsPerCell) {
  // A field of view of 90 degrees: the focal length is half the width.
  EXPECT_NEAR(focalOf(640, 90), 320, 1e-9);
  // 40 mm / 6 cells * 560 px / 1.1 m.
  EXPECT_NEAR(cellPixels(Board(), {560, 1.1}), 3.394, 1e-3);
  EXPECT_NEAR(cellPixels(chessboard(10, 7), {560, 0.5}), 28, 1e-9);
  EXPECT_EQ(defaultMarker(0.054), 0.040);
  EXPECT_EQ(defaultMarker(0.055), 0.041);
}

TEST(BoardAdvice, ProposesReadableBoardThatFits) {
  int proposals = 0;
  for (const double distance_m : {0.3, 0.6, 1.1, 1.8, 2.2})
    for (const Page page : {Page::kA4, Page::kA3}) {
      const auto proposal = readableBoard(Board(), {560, distance_m}, page);
      if (!proposal) continue;
      ++proposals;
      EXPECT_GE(proposal->cell_px, 3);
      EXPECT_NEAR(proposal->cell_px, cellPixels(proposal->board, {560, distance_m}), 1e-12);
      layOut(proposal->board, proposal->page);  // throws if it does not fit
      // The proposed board is detected.
      Camera camera = webcam();
      camera.lens.fx = camera.lens.fy = 560;
      const Pose pose = boardBefore(proposal->board, camera, distance_m);
      EXPECT_TRUE(look(proposal->board, camera,
                       drawBoard(proposal->board, camera, pose, {.noise_sigma = 2.5, .blur_px = 0.5})))
          << distance_m;
    }
  EXPECT_GE(proposals, 8);
  EXPECT_FALSE(readableBoard(Board(), {560, 20}, Page::kA4));
}

}  // namespace
}  // namespace airclay
