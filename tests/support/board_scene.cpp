// SPDX-License-Identifier: MIT
#include "tests/support/board_scene.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

#include "capture/calibration/board_pattern.h"

namespace airclay {
namespace {

// Rays are exact at every second pixel corner and interpolated in between: with the strongest distortion of
// the tests, the error is below 0.001 px.
constexpr int kStep = 2;
constexpr int kSamples = 64;

/// A lattice of 64 points in the unit square whose projections on either axis are 64 evenly spaced values:
/// vertical edges are sampled as finely as slanted ones.
const std::array<Vec2, kSamples>& samples() {
  static const std::array<Vec2, kSamples> points = [] {
    std::array<Vec2, kSamples> made;
    for (int i = 0; i < kSamples; ++i) made[size_t(i)] = Vec2(i + 0.5, i * 19 % kSamples + 0.5) / kSamples;
    return made;
  }();
  return points;
}

/// The area on the board's plane that a pixel sees.
class BoardPlane {
 public:
  BoardPlane(const Camera& camera, const Pose& world_from_board)
      : lens_(camera.lens), board_from_camera_((camera.camera_from_world * world_from_board).inverse()) {}

  bool shows(const Board& board) const { return board.two_sided || board_from_camera_.translation().z() < 0; }

  /// NaN if the pixel's ray does not meet the plane.
  Vec2 at(const Vec2& pixel) const {
    const Vec2 nowhere = Vec2::Constant(std::nan(""));
    const std::optional<Vec3> ray = rayThroughPixel(lens_, pixel);
    if (!ray) return nowhere;
    const Vec3 origin = board_from_camera_.translation(), direction = board_from_camera_.linear() * *ray;
    const double length = -origin.z() / direction.z();
    if (!(length > 0)) return nowhere;
    return (origin + length * direction).head<2>();
  }

 private:
  Lens lens_;
  Pose board_from_camera_;
};

/// Points on the plane for the corners of a tile of kStep x kStep pixels.
struct Tile {
  Vec2 upper_left, upper_right, lower_left, lower_right;

  /// \param share position within the tile, 0 to 1 along either axis
  Vec2 at(const Vec2& share) const {
    const Vec2 upper = upper_left + share.x() * (upper_right - upper_left);
    const Vec2 lower = lower_left + share.x() * (lower_right - lower_left);
    return upper + share.y() * (lower - upper);
  }
};

/// The grey value at a point of the plane.
class Sheet {
 public:
  Sheet(const Board& board, const BoardShot& shot, bool printed)
      : pattern_(board), shot_(shot), printed_(printed) {
    const double inset = (board.square_m - board.marker_m) / 2;
    cell_m_ = pattern_.markerCells() ? board.marker_m / pattern_.markerCells() : board.square_m;
    inset_m_ = board.chessboard ? 0 : inset;
  }

  double at(const Vec2& point) const {
    const Board& board = pattern_.board();
    const bool on_paper = point.x() > -shot_.paper_m && point.x() < board.widthM() + shot_.paper_m &&
                          point.y() > -shot_.paper_m && point.y() < board.heightM() + shot_.paper_m;
    if (!on_paper) return shot_.background;
    return printed_ && pattern_.isBlack(point) ? shot_.black : shot_.white;
  }

  /// Whether a box certainly contains no edge: all its points are in one cell of a marker, in one part of a
  /// square, or far outside the paper.
  bool isPlain(const Vec2& low, const Vec2& high) const {
    const Board& board = pattern_.board();
    const Vec2 size(board.widthM(), board.heightM());
    if ((high.array() < -shot_.paper_m).any() || (low.array() > size.array() + shot_.paper_m).any())
      return true;
    return stripe(low.x()) == stripe(high.x()) && stripe(low.y()) == stripe(high.y());
  }

 private:
  /// The number of lines before `x` along one axis: edges of squares, markers, cells, and of
  /// the paper.
  int stripe(double x) const {
    const Board& board = pattern_.board();
    const int square = static_cast<int>(std::floor(x / board.square_m));
    const double inside = x - square * board.square_m;
    int in_square = 0;
    if (inset_m_ > 0 && inside > inset_m_)
      in_square = 1 + static_cast<int>(std::min(inside - inset_m_, board.marker_m) / cell_m_);
    const bool on_paper = x > -shot_.paper_m;
    return square * 100 + in_square + (on_paper ? 0 : -100000) + pastPaper(x);
  }
  int pastPaper(double x) const {
    const Board& board = pattern_.board();
    return (x > board.widthM() + shot_.paper_m ? 1000000 : 0) +
           (x > board.heightM() + shot_.paper_m ? 2000000 : 0);
  }

  BoardPattern pattern_;
  BoardShot shot_;
  bool printed_;  ///< whether the visible side is printed
  double cell_m_, inset_m_;
};

double greyOf(const Sheet& sheet, const Tile& tile, int x, int y) {
  const Vec2 corner = Vec2(x, y) / kStep;
  const double side = 1.0 / kStep;
  const Vec2 a = tile.at(corner), b = tile.at(corner + Vec2(side, 0)), c = tile.at(corner + Vec2(0, side)),
             d = tile.at(corner + Vec2(side, side));
  const Vec2 low = a.cwiseMin(b).cwiseMin(c).cwiseMin(d), high = a.cwiseMax(b).cwiseMax(c).cwiseMax(d);
  if (!low.allFinite() || !high.allFinite() || sheet.isPlain(low, high)) return sheet.at((a + d) / 2);
  double sum = 0;
  for (const Vec2& share : samples()) sum += sheet.at(tile.at(corner + side * share));
  return sum / kSamples;
}

cv::Mat1f drawSharp(const Sheet& sheet, const BoardPlane& plane, int width, int height) {
  const int columns = (width + kStep - 1) / kStep, rows = (height + kStep - 1) / kStep;
  std::vector<Vec2> upper, lower;
  const auto rowOfPoints = [&](int row) {
    std::vector<Vec2> points;
    for (int i = 0; i <= columns; ++i) points.push_back(plane.at(Vec2(i * kStep - 0.5, row * kStep - 0.5)));
    return points;
  };
  cv::Mat1f grey(height, width);
  lower = rowOfPoints(0);
  for (int row = 0; row < rows; ++row) {
    upper = std::move(lower);
    lower = rowOfPoints(row + 1);
    for (int i = 0; i < columns; ++i) {
      const Tile tile{upper[size_t(i)], upper[size_t(i) + 1], lower[size_t(i)], lower[size_t(i) + 1]};
      for (int y = 0; y < kStep && row * kStep + y < height; ++y)
        for (int x = 0; x < kStep && i * kStep + x < width; ++x)
          grey(row * kStep + y, i * kStep + x) = static_cast<float>(greyOf(sheet, tile, x, y));
    }
  }
  return grey;
}

}  // namespace

std::vector<std::uint8_t> drawBoard(const Board& board, const Camera& camera, const Pose& world_from_board,
                                    const BoardShot& shot) {
  const BoardPlane plane(camera, world_from_board);
  cv::Mat1f grey = drawSharp(Sheet(board, shot, plane.shows(board)), plane, camera.width, camera.height);
  if (shot.blur_px > 0) cv::GaussianBlur(grey, grey, {}, shot.blur_px, shot.blur_px, cv::BORDER_REPLICATE);
  std::mt19937 random(shot.seed);
  std::normal_distribution<float> noise(0, static_cast<float>(shot.noise_sigma));
  std::vector<std::uint8_t> bgr;
  bgr.reserve(grey.total() * 3);
  for (const float value : grey) {
    const float noisy = shot.noise_sigma > 0 ? value + noise(random) : value;
    bgr.insert(bgr.end(), 3, static_cast<std::uint8_t>(std::lround(std::clamp(noisy, 0.0f, 255.0f))));
  }
  return bgr;
}

BoardView trueView(const Board& board, const Camera& camera, const Pose& world_from_board, double margin_px) {
  BoardView view;
  if (!BoardPlane(camera, world_from_board).shows(board)) return view;
  for (int id = 0; id < board.cornerCount(); ++id) {
    const std::optional<Vec2> pixel = project(camera, world_from_board * board.corner(id));
    if (!pixel || pixel->x() < margin_px - 0.5 || pixel->y() < margin_px - 0.5 ||
        pixel->x() > camera.width - 0.5 - margin_px || pixel->y() > camera.height - 0.5 - margin_px)
      continue;
    view.ids.push_back(id);
    view.pixels.push_back(*pixel);
  }
  return view;
}

Pose boardBefore(const Board& board, const Camera& camera, double distance_m, const Vec3& turn,
                 const Vec3& offset_m) {
  const Vec3 center_in_board(board.widthM() / 2, board.heightM() / 2, 0);
  Pose camera_from_board = Pose::Identity();
  camera_from_board.linear() = rotationFromVector(turn);
  camera_from_board.translation() =
      Vec3(0, 0, distance_m) + offset_m - camera_from_board.linear() * center_in_board;
  return camera.camera_from_world.inverse() * camera_from_board;
}

}  // namespace airclay
