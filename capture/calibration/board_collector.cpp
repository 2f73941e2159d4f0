// SPDX-License-Identifier: MIT
#include "capture/calibration/board_collector.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <limits>
#include <utility>

#include "capture/calibration/calibration_parts.h"

namespace airclay {
namespace {

// The maximum motion of a resting board between two cameras' images: about the error of a corner.
constexpr double kRestingPx = 0.3;
// A position is new if its corners are, on average, this fraction of the image's width from all others.
constexpr double kNewPosition = 0.04;
// The board is tilted if the logarithm of the ratio of a square's sides, or the deviation of their angle from
// 90 degrees in radians, exceeds this: a tilt of 25 to 30 degrees.
constexpr double kTilted = 0.12;
// Grey values from 0 to 255.
constexpr double kDark = 70, kBright = 250, kLowContrast = 50;
constexpr double kBlurredPx = 1.3;
// Consecutive sets after which the advice mentions that no camera sees the board, or that it moves.
constexpr int kManyBoardless = 15, kManyMoving = 20;

/// The mean distance between the corners that both views contain, pixels; empty if there are fewer than
/// three.
std::optional<double> distanceBetween(const BoardView& a, const BoardView& b) {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0, j = 0; i < a.ids.size() && j < b.ids.size();) {
    if (a.ids[i] == b.ids[j]) {
      sum += (a.pixels[i++] - b.pixels[j++]).norm();
      ++count;
    } else {
      ++(a.ids[i] < b.ids[j] ? i : j);
    }
  }
  if (count < 3) return std::nullopt;
  return sum / count;
}

/// Whether the board is tilted, judged by the foreshortening of its squares.
bool isTilted(const Board& board, const BoardView& view) {
  Vec2 row = Vec2::Zero(), column = Vec2::Zero();
  int rows = 0, columns = 0;
  for (std::size_t i = 0; i < view.ids.size(); ++i)
    for (std::size_t j = i + 1; j < view.ids.size(); ++j) {
      const int steps = view.ids[j] - view.ids[i];
      if (steps == 1 && view.ids[j] % board.cornersX() != 0) {
        row += view.pixels[j] - view.pixels[i];
        ++rows;
      }
      if (steps == board.cornersX()) {
        column += view.pixels[j] - view.pixels[i];
        ++columns;
      }
    }
  if (rows == 0 || columns == 0) return false;
  row /= rows;
  column /= columns;
  const double foreshortening = std::abs(std::log(row.norm() / column.norm()));
  const double shear = std::abs(std::asin(std::clamp(row.normalized().dot(column.normalized()), -1.0, 1.0)));
  return std::max(foreshortening, shear) > kTilted;
}

double fractionOf(double value, double target) {
  return std::min(1.0, value / target);
}

}  // namespace

std::string CollectedCamera::problem() const {
  if (!light) return {};
  if (light->white < kDark) return "too dark";
  if (light->black > kBright - kLowContrast || light->white >= kBright) return "too bright";
  if (light->white - light->black < kLowContrast) return "low contrast";
  if (light->blur_px > kBlurredPx) return "blurred";
  return {};
}

double BoardCollector::progressOf(const CollectedCamera& camera) const {
  const RequiredViews& required = options_.required;
  return (fractionOf(camera.views, required.views) + fractionOf(camera.shared_views, required.shared) +
          fractionOf(camera.coverage.fraction(), required.coverage) +
          fractionOf(camera.tilted_views, required.tilted)) /
         4;
}

BoardCollector::BoardCollector(const Board& board,
                               const std::vector<std::pair<std::string, ImageSize>>& cameras,
                               const Options& options)
    : detector_(board), options_(options), previous_(cameras.size()) {
  for (const auto& [name, size] : cameras) {
    cameras_.push_back({name, size, {}, {}, 0, 0, 0, BoardCoverage(size)});
    views_.push_back({name, size.width, size.height, {}});
  }
  shared_.assign(cameras.size(), std::vector<int>(cameras.size(), 0));
}

bool BoardCollector::add(const LiveSet& set) {
  for (std::size_t c = 0; c < cameras_.size(); ++c)
    previous_[c] = std::exchange(cameras_[c].seen, std::nullopt);
  const auto detect = [&](std::size_t first) {
    for (std::size_t c = first; c < cameras_.size(); c += static_cast<std::size_t>(options_.threads)) {
      const LiveImage& image = set.images[c];
      CollectedCamera& camera = cameras_[c];
      if (image.bgr.empty() || image.size != camera.size) continue;
      camera.seen = detector_.find(image.size, PixelFormat::kBgr8, image.bgr);
      if (camera.seen) camera.light = camera.seen->exposure;
    }
  };
  std::vector<std::future<void>> others;
  for (int i = 1; i < options_.threads; ++i)
    others.push_back(std::async(std::launch::async, detect, static_cast<std::size_t>(i)));
  detect(0);
  for (std::future<void>& other : others) other.get();

  const int number = sets_++;
  const bool seen = std::any_of(cameras_.begin(), cameras_.end(), [](const auto& c) { return c.seen; });
  const bool is_new = seen && isNew(), at_rest = atRest(set);
  boardless_sets_ = seen ? 0 : boardless_sets_ + 1;
  moving_sets_ = is_new && !at_rest ? moving_sets_ + 1 : 0;
  previous_s_ = set.time_s;
  if (!is_new || !at_rest || selected_sets_ >= kMaxSets) return false;
  select(number);
  return true;
}

/// Whether the camera sees enough corners to determine the board's pose.
bool BoardCollector::isUsable(std::size_t camera) const {
  return cameras_[camera].seen && usableView(board(), *cameras_[camera].seen);
}

/// Whether the board moves so slowly that the cameras' skew displaces no view by more than kRestingPx.
bool BoardCollector::atRest(const LiveSet& set) const {
  const double passed_s = set.time_s - previous_s_;
  if (!(passed_s > 0)) return false;
  const double skew_s = std::max(set.skew_s, options_.unseen_skew_s);
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    if (!cameras_[c].seen) continue;
    if (!previous_[c]) return false;
    const std::optional<double> moved_px = distanceBetween(*cameras_[c].seen, *previous_[c]);
    if (!moved_px || *moved_px / passed_s * skew_s > kRestingPx) return false;
  }
  return true;
}

bool BoardCollector::isNew() const {
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    if (!isUsable(c)) continue;
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& [number, view] : views_[c].views)
      if (const auto distance = distanceBetween(view, *cameras_[c].seen))
        nearest = std::min(nearest, *distance);
    if (nearest > kNewPosition * cameras_[c].size.width) return true;
  }
  return false;
}

void BoardCollector::select(int number) {
  std::vector<std::size_t> seeing;
  for (std::size_t c = 0; c < cameras_.size(); ++c)
    if (isUsable(c)) seeing.push_back(c);
  for (const std::size_t c : seeing) {
    CollectedCamera& camera = cameras_[c];
    views_[c].views[number] = *camera.seen;
    ++camera.views;
    camera.shared_views += seeing.size() > 1;
    camera.tilted_views += isTilted(board(), *camera.seen);
    for (const Vec2& pixel : camera.seen->pixels) camera.coverage.add(pixel);
    camera.progress = progressOf(camera);
    for (const std::size_t other : seeing) ++shared_[c][other];
  }
  ++selected_sets_;
}

std::optional<int> BoardCollector::selectForWorld() {
  bool usable = false;
  for (std::size_t c = 0; c < cameras_.size(); ++c) usable = usable || isUsable(c);
  if (!usable) return std::nullopt;
  const int number = sets_ - 1;
  const bool selected =
      std::any_of(views_.begin(), views_.end(), [&](const auto& of) { return of.views.count(number); });
  if (!selected) select(number);
  return number;
}

void BoardCollector::clear() {
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    cameras_[c] = {cameras_[c].name, cameras_[c].size, {}, {}, 0, 0, 0, BoardCoverage(cameras_[c].size)};
    views_[c].views.clear();
  }
  for (std::vector<int>& row : shared_) std::fill(row.begin(), row.end(), 0);
  selected_sets_ = 0;
}

/// The groups of cameras that shared views connect, largest first.
std::vector<std::vector<int>> BoardCollector::groups() const {
  constexpr int kMinSharedByPair = 4;
  std::vector<std::vector<int>> groups;
  std::vector<char> placed(cameras_.size(), 0);
  for (std::size_t first = 0; first < cameras_.size(); ++first) {
    if (placed[first]) continue;
    std::vector<int> group = {static_cast<int>(first)};
    placed[first] = 1;
    for (std::size_t i = 0; i < group.size(); ++i)
      for (std::size_t c = 0; c < cameras_.size(); ++c)
        if (!placed[c] && shared_[static_cast<std::size_t>(group[i])][c] >= kMinSharedByPair) {
          placed[c] = 1;
          group.push_back(static_cast<int>(c));
        }
    groups.push_back(std::move(group));
  }
  std::sort(groups.begin(), groups.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return groups;
}

double BoardCollector::progress() const {
  double sum = 0;
  for (const CollectedCamera& camera : cameras_) sum += camera.progress;
  const double cameras = static_cast<double>(cameras_.size());
  return 0.9 * sum / cameras + 0.1 * (groups().size() == 1 ? 1 : 0);
}

bool BoardCollector::enough() const {
  return groups().size() == 1 && std::all_of(cameras_.begin(), cameras_.end(),
                                             [](const CollectedCamera& c) { return c.progress >= 1; });
}

std::string BoardCollector::advice() const {
  if (enough()) return "enough views";
  if (boardless_sets_ > kManyBoardless || (sets_ > 0 && selected_sets_ == 0 && boardless_sets_ > 0))
    return "no camera sees the board; hold it in the workspace";
  if (moving_sets_ > kManyMoving) return "hold the board still for a moment, then move on";
  const auto least = std::min_element(cameras_.begin(), cameras_.end(),
                                      [](const auto& a, const auto& b) { return a.progress < b.progress; });
  const std::string problem = least->problem();
  if (!problem.empty()) {
    const std::string remedy = problem == "too dark"       ? "add light"
                               : problem == "too bright"   ? "reduce the light or the exposure"
                               : problem == "low contrast" ? "light the board evenly, and avoid reflections"
                                                           : "focus the camera, or clean its lens";
    const std::string state = problem == "low contrast" ? "has low contrast" : "is " + problem;
    return "the board " + state + " for " + least->name + "; " + remedy;
  }
  const std::vector<std::vector<int>> unconnected = groups();
  if (least->progress >= 1 && unconnected.size() > 1)
    return "hold the board where both " + cameras_[static_cast<std::size_t>(unconnected[1][0])].name +
           " and " + cameras_[static_cast<std::size_t>(unconnected[0][0])].name + " see it";
  if (least->views < options_.required.views)
    return "show the board to " + least->name + " in more positions";
  if (least->shared_views < options_.required.shared)
    return "hold the board where both " + least->name + " and another camera see it";
  if (least->coverage.fraction() < options_.required.coverage) {
    const std::string sides = least->coverage.emptySides();
    return "move the board to parts of the image of " + least->name + " where it has not been" +
           (sides.empty() ? "" : ": " + sides);
  }
  return "tilt the board in front of " + least->name + " by about 30 degrees in all directions";
}

}  // namespace airclay
