// SPDX-License-Identifier: MIT
// Detects ChArUco boards in three steps. OpenCV detects markers. Markers belong to the board if they predict
// each other's positions. Each marker predicts the corners of its square, which saddle_point.h then refines.
// Chessboards: chessboard_detector.h. interpolateCornersCharuco() of OpenCV 4.6 is not used because its
// corners are half a pixel too far right and down.
#include "capture/calibration/board_detector.h"

#include <algorithm>
#include <numbers>
#include <opencv2/aruco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "capture/calibration/aruco_dictionary.h"
#include "capture/calibration/board_exposure.h"
#include "capture/calibration/board_pattern.h"
#include "capture/calibration/chessboard_detector.h"
#include "capture/calibration/saddle_point.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

// Two markers agree if each is within this fraction of a square of the position that the other predicts. The
// error of a marker of another board is at least one square. A marker's corners are known to about half a
// pixel, and its neighbour's distance is twice its size.
constexpr double kAgreement = 0.4;

// At least this fraction of the markers next to detected corners must be detected, because two markers of a
// mirrored board can be read as markers of this board and agree.
constexpr double kMinDetected = 0.35;

/// A homography from the board's plane, in squares, to pixels.
class PlaneToImage {
 public:
  explicit PlaneToImage(const cv::Matx33d& matrix) {
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) matrix_(r, c) = matrix(r, c);
  }

  Vec2 at(const Vec2& squares) const { return (matrix_ * squares.homogeneous()).hnormalized(); }
  /// The derivative, pixels per square.
  Mat2 derivativeAt(const Vec2& squares) const {
    const Vec3 h = matrix_ * squares.homogeneous();
    return (matrix_.topLeftCorner<2, 2>() - h.hnormalized() * matrix_.block<1, 2>(2, 0)) / h.z();
  }

 private:
  Mat3 matrix_;
};

struct DetectedMarker {
  int id;
  Vec2 center;  ///< squares
  Vec2 pixel;   ///< the centre in the image
  std::vector<cv::Point2f> board_corners, pixel_corners;
  PlaneToImage plane;
};

/// Groups neighbouring markers that agree; returns each marker's group number.
std::vector<int> groupsOf(const std::vector<DetectedMarker>& markers) {
  std::vector<int> group(markers.size());
  for (std::size_t i = 0; i < group.size(); ++i) group[i] = static_cast<int>(i);
  const auto predicts = [](const DetectedMarker& a, const DetectedMarker& b) {
    const double square_px = std::sqrt(std::abs(a.plane.derivativeAt(a.center).determinant()));
    return (a.plane.at(b.center) - b.pixel).norm() <= kAgreement * square_px;
  };
  for (std::size_t i = 0; i < markers.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const DetectedMarker &a = markers[i], &b = markers[j];
      // Neighbours are diagonally adjacent, or two squares spacing in a row or column.
      if (a.id == b.id || (a.center - b.center).norm() > 2.1 || group[i] == group[j]) continue;
      if (predicts(a, b) && predicts(b, a)) std::replace(group.begin(), group.end(), group[i], group[j]);
    }
  return group;
}

std::optional<PlaneToImage> planeThrough(const std::vector<cv::Point2f>& from,
                                         const std::vector<cv::Point2f>& to) {
  if (from.size() < 4) return std::nullopt;
  const cv::Mat matrix = cv::findHomography(from, to);
  return matrix.empty() ? std::nullopt : std::optional(PlaneToImage(cv::Matx33d(matrix)));
}

std::optional<PlaneToImage> planeThrough(const std::vector<DetectedMarker>& markers) {
  std::vector<cv::Point2f> from, to;
  for (const DetectedMarker& marker : markers) {
    from.insert(from.end(), marker.board_corners.begin(), marker.board_corners.end());
    to.insert(to.end(), marker.pixel_corners.begin(), marker.pixel_corners.end());
  }
  return planeThrough(from, to);
}

/// The markers of the largest group, and others that fit its homography. Empty if no two markers agree, or
/// the group has less than half of the markers.
std::vector<DetectedMarker> markersOfOneBoard(const std::vector<DetectedMarker>& markers) {
  const std::vector<int> groups = groupsOf(markers);
  int largest = -1, size = 1;
  for (const int group : groups) {
    const int count = static_cast<int>(std::count(groups.begin(), groups.end(), group));
    if (count > size) largest = group, size = count;
  }
  std::vector<DetectedMarker> agreeing;
  for (std::size_t i = 0; i < markers.size(); ++i)
    if (groups[i] == largest) agreeing.push_back(markers[i]);
  if (agreeing.empty() || 2 * agreeing.size() < markers.size()) return {};
  const std::optional<PlaneToImage> plane = planeThrough(agreeing);
  for (std::size_t i = 0; i < markers.size(); ++i) {
    const DetectedMarker& marker = markers[i];
    if (groups[i] == largest || !plane) continue;
    const double square_px = std::sqrt(std::abs(plane->derivativeAt(marker.center).determinant()));
    if ((plane->at(marker.center) - marker.pixel).norm() <= kAgreement * square_px)
      agreeing.push_back(marker);
  }
  return agreeing;
}

/// By corner id; empty if not detected.
using Corners = std::vector<std::optional<SaddlePoint>>;

/// Whether there are at least four corners, and not all are collinear.
bool spansAPlane(const Board& board, const std::vector<int>& ids) {
  if (ids.size() < 4) return false;
  const Vec3 first = board.corner(ids[0]) / board.square_m;
  Vec3 other = first;
  for (const int id : ids) {
    const Vec3 corner = board.corner(id) / board.square_m;
    if ((corner - first).norm() > (other - first).norm()) other = corner;
  }
  return std::any_of(ids.begin(), ids.end(), [&](int id) {
    return (board.corner(id) / board.square_m - first).cross(other - first).norm() > 0.5;
  });
}

}  // namespace

struct BoardDetector::Parts {
  explicit Parts(const Board& board) : pattern(board) {
    if (board.chessboard) return;
    dictionary = cv::aruco::getPredefinedDictionary(arucoDictionary(board.dictionary)->opencv_number);
    parameters = cv::aruco::DetectorParameters::create();
    // Chosen with synthetic images of boards with cells of 2 to 5 pixels: detects up to 1.8 times as many
    // markers as OpenCV's defaults. The occasional wrong marker does not agree with the others.
    parameters->polygonalApproxAccuracyRate = 0.05;
    parameters->perspectiveRemovePixelPerCell = 8;
    parameters->perspectiveRemoveIgnoredMarginPerCell = 0.25;
    parameters->errorCorrectionRate = 1;
    parameters->maxErroneousBitsInBorderRate = 0.5;
    // Of two outlines closer than this, as a fraction of a marker's perimeter, OpenCV keeps the outer one.
    // The outline of the white square around a marker must not replace that of the marker.
    const double spacing = std::numbers::sqrt2 * (board.square_m - board.marker_m) / 2 / (4 * board.marker_m);
    parameters->minMarkerDistanceRate = std::min(0.05, 0.4 * spacing);
  }

  const Board& board() const { return pattern.board(); }

  std::vector<DetectedMarker> findMarkers(const cv::Mat& grey) const;
  std::optional<BoardView> findCharuco(const cv::Mat& grey) const;
  std::optional<SaddleGuess> guessFrom(const std::vector<const DetectedMarker*>& markers, int id) const;

  void findCornersAtMarkers(const GreyImage& image, const std::vector<DetectedMarker>& found,
                            Corners& corners) const;
  void findCornersAtCorners(const GreyImage& image, Corners& corners) const;

  /// The number of markers whose squares have at least two detected corners.
  int markersNextTo(const Corners& corners) const;

  Vec2 inSquares(int id) const { return board().corner(id).head<2>() / board().square_m; }
  double whiteMargin() const {
    return board().chessboard ? 1 : (board().square_m - board().marker_m) / (2 * board().square_m);
  }

  BoardPattern pattern;
  cv::Ptr<cv::aruco::Dictionary> dictionary;
  cv::Ptr<cv::aruco::DetectorParameters> parameters;
};

std::vector<DetectedMarker> BoardDetector::Parts::findMarkers(const cv::Mat& grey) const {
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  cv::aruco::detectMarkers(grey, dictionary, corners, ids, parameters);
  const double side = board().marker_m / board().square_m;
  std::vector<DetectedMarker> markers;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (ids[i] >= pattern.markerCount()) continue;
    const Vec2 low = pattern.markerCorner(ids[i]) / board().square_m;
    const cv::Point2f at(static_cast<float>(low.x()), static_cast<float>(low.y()));
    const float s = static_cast<float>(side);
    const std::vector<cv::Point2f> on_board{at, at + cv::Point2f(s, 0), at + cv::Point2f(s, s),
                                            at + cv::Point2f(0, s)};
    const PlaneToImage plane(cv::Matx33d(cv::getPerspectiveTransform(on_board, corners[i])));
    const Vec2 center = low + Vec2::Constant(side / 2);
    markers.push_back({ids[i], center, plane.at(center), on_board, corners[i], plane});
  }
  return markers;
}

/// The mean prediction of a corner by the markers of the squares around it; empty if there are none.
std::optional<SaddleGuess> BoardDetector::Parts::guessFrom(const std::vector<const DetectedMarker*>& markers,
                                                           int id) const {
  const int column = id % board().cornersX(), row = id / board().cornersX();
  const Vec2 corner(column + 1, row + 1);
  SaddleGuess guess{Vec2::Zero(), Mat2::Zero(), board().blackBefore(id), whiteMargin()};
  int count = 0;
  for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {0, 1}, {1, 1}}) {
    const std::optional<int> marker = pattern.markerIn(column + x, row + y);
    const DetectedMarker* seen = marker ? markers[static_cast<std::size_t>(*marker)] : nullptr;
    if (!seen) continue;
    guess.pixel += seen->plane.at(corner);
    guess.pixels_from_squares += seen->plane.derivativeAt(corner);
    ++count;
  }
  if (count == 0) return std::nullopt;
  guess.pixel /= count, guess.pixels_from_squares /= count;
  return guess;
}

void BoardDetector::Parts::findCornersAtMarkers(const GreyImage& image,
                                                const std::vector<DetectedMarker>& found,
                                                Corners& corners) const {
  std::vector<const DetectedMarker*> markers(static_cast<std::size_t>(pattern.markerCount()));
  for (const DetectedMarker& marker : found) markers[static_cast<std::size_t>(marker.id)] = &marker;
  for (int id = 0; id < board().cornerCount(); ++id)
    if (const std::optional<SaddleGuess> guess = guessFrom(markers, id))
      corners[static_cast<std::size_t>(id)] = findCorner(image, *guess);
}

/// Finds corners without markers, outwards from their known neighbours. Predicts each by a homography through
/// all known corners, plus the neighbour's deviation from it.
void BoardDetector::Parts::findCornersAtCorners(const GreyImage& image, Corners& corners) const {
  std::vector<cv::Point2f> from, to;
  for (int id = 0; id < board().cornerCount(); ++id)
    if (const std::optional<SaddlePoint>& corner = corners[static_cast<std::size_t>(id)]) {
      from.emplace_back(static_cast<float>(inSquares(id).x()), static_cast<float>(inSquares(id).y()));
      to.emplace_back(static_cast<float>(corner->pixel.x()), static_cast<float>(corner->pixel.y()));
    }
  const std::optional<PlaneToImage> plane = planeThrough(from, to);
  std::vector<int> next;  // corners whose neighbours have not been searched for
  for (int id = 0; id < board().cornerCount(); ++id)
    if (corners[static_cast<std::size_t>(id)]) next.push_back(id);
  while (plane && !next.empty()) {
    const int known = next.back(), column = known % board().cornersX(), row = known / board().cornersX();
    next.pop_back();
    const Vec2 deviation = corners[static_cast<std::size_t>(known)]->pixel - plane->at(inSquares(known));
    for (const auto& [x, y] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
      if (column + x < 0 || column + x >= board().cornersX()) continue;
      if (row + y < 0 || row + y >= board().cornersY()) continue;
      const int id = known + x + y * board().cornersX();
      std::optional<SaddlePoint>& corner = corners[static_cast<std::size_t>(id)];
      if (corner) continue;
      corner = findCorner(image, {plane->at(inSquares(id)) + deviation, plane->derivativeAt(inSquares(id)),
                                  board().blackBefore(id), whiteMargin()});
      if (corner) next.push_back(id);
    }
  }
}

int BoardDetector::Parts::markersNextTo(const Corners& corners) const {
  int count = 0;
  for (int row = 0; row < board().squares_y; ++row)
    for (int column = 0; column < board().squares_x; ++column) {
      int known = 0;
      for (const auto& [x, y] : {std::pair{-1, -1}, {0, -1}, {-1, 0}, {0, 0}}) {
        const bool is_inner = column + x >= 0 && column + x < board().cornersX() && row + y >= 0 &&
                              row + y < board().cornersY();
        if (is_inner)
          known += corners[static_cast<std::size_t>((row + y) * board().cornersX() + column + x)].has_value();
      }
      count += known >= 2 && pattern.markerIn(column, row);
    }
  return count;
}

std::optional<BoardView> BoardDetector::Parts::findCharuco(const cv::Mat& grey) const {
  const GreyImage image{grey.cols, grey.rows, grey.data};
  Corners corners(static_cast<std::size_t>(board().cornerCount()));
  const std::vector<DetectedMarker> found = markersOfOneBoard(findMarkers(grey));
  findCornersAtMarkers(image, found, corners);
  findCornersAtCorners(image, corners);
  std::set<int> read;  // OpenCV may detect the same marker twice
  for (const DetectedMarker& marker : found) read.insert(marker.id);
  if (static_cast<double>(read.size()) < kMinDetected * markersNextTo(corners)) return std::nullopt;
  BoardView view;
  std::vector<SaddlePoint> found_corners;
  for (std::size_t id = 0; id < corners.size(); ++id) {
    if (!corners[id]) continue;
    view.ids.push_back(static_cast<int>(id));
    view.pixels.push_back(corners[id]->pixel);
    found_corners.push_back(*corners[id]);
  }
  if (!spansAPlane(board(), view.ids)) return std::nullopt;
  view.exposure = exposureOf(found_corners);
  return view;
}

BoardDetector::BoardDetector(const Board& board) : parts_(std::make_unique<Parts>(board)) {}
BoardDetector::~BoardDetector() = default;
BoardDetector::BoardDetector(BoardDetector&&) noexcept = default;
BoardDetector& BoardDetector::operator=(BoardDetector&&) noexcept = default;

const Board& BoardDetector::board() const {
  return parts_->board();
}

std::optional<BoardView> BoardDetector::find(ImageSize size, PixelFormat format,
                                             std::span<const std::uint8_t> pixels) const {
  const std::size_t expected = std::size_t(size.width) * std::size_t(size.height) * std::size_t(format);
  if (size.width < 1 || size.height < 1 || pixels.size() != expected)
    throw Error("an image of " + std::to_string(size.width) + " x " + std::to_string(size.height) +
                " pixels has " + std::to_string(pixels.size()) + " bytes; expected " +
                std::to_string(expected));
  const bool is_grey = format == PixelFormat::kGrey8;
  // cv::Mat has no read-only view; OpenCV only reads these pixels.
  cv::Mat grey(size.height, size.width, is_grey ? CV_8UC1 : CV_8UC3,
               const_cast<std::uint8_t*>(pixels.data()));
  if (!is_grey) {
    cv::Mat converted;
    cv::cvtColor(grey, converted, cv::COLOR_BGR2GRAY);
    grey = converted;
  }
  if (board().inverted) {
    cv::Mat inverted;
    cv::bitwise_not(grey, inverted);
    grey = inverted;
  }
  if (board().chessboard) return findChessboard(board(), {grey.cols, grey.rows, grey.data});
  std::optional<BoardView> view = parts_->findCharuco(grey);
  if (view || !board().two_sided) return view;
  cv::Mat mirrored;
  cv::flip(grey, mirrored, 1);
  view = parts_->findCharuco(mirrored);
  if (view)
    for (Vec2& pixel : view->pixels) pixel.x() = size.width - 1 - pixel.x();
  return view;
}

}  // namespace airclay
