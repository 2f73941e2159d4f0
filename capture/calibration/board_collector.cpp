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

// What a board may move by between two cameras' images of it, pixels: that of a corner's own error.
constexpr double kStill_px = 0.3;
// A board is elsewhere when its corners are, on average, by this share of the image's width.
constexpr double kElsewhere = 0.04;
// A square's rows and columns look this much unlike in length, or askew by so many radians: 25 to 30 degrees.
constexpr double kTilted = 0.12;
// Grey values of 255 and pixels.
constexpr double kDark = 70, kBright = 250, kFlat = 50, kBlurred_px = 1.3;
// Of sets in a row.
constexpr int kLongUnseen = 15, kLongHurried = 20;

/// The mean distance between the corners that both have; none when they have too few.
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

/// Whether the board is turned away from the camera, by how its rows and columns are foreshortened.
bool isTilted(const Board& board, const BoardView& view) {
  Vec2 row = Vec2::Zero(), column = Vec2::Zero();
  int rows = 0, columns = 0;
  for (std::size_t i = 0; i < view.ids.size(); ++i)
    for (std::size_t j = i + 1; j < view.ids.size(); ++j) {
      const int apart = view.ids[j] - view.ids[i];
      if (apart == 1 && view.ids[j] % board.cornersX() != 0) {
        row += view.pixels[j] - view.pixels[i];
        ++rows;
      }
      if (apart == board.cornersX()) {
        column += view.pixels[j] - view.pixels[i];
        ++columns;
      }
    }
  if (rows == 0 || columns == 0) return false;
  row /= rows;
  column /= columns;
  const double unlike = std::abs(std::log(row.norm() / column.norm()));
  const double askew = std::abs(std::asin(std::clamp(row.normalized().dot(column.normalized()), -1.0, 1.0)));
  return std::max(unlike, askew) > kTilted;
}

double reached(double value, double target) {
  return std::min(1.0, value / target);
}

}  // namespace

std::string CollectedCamera::fault() const {
  if (!light) return {};
  if (light->white < kDark) return "too dark";
  if (light->black > kBright - kFlat || light->white >= kBright) return "too bright";
  if (light->white - light->black < kFlat) return "flat light";
  if (light->blur_px > kBlurred_px) return "not sharp";
  return {};
}

double BoardCollector::shareOf(const CollectedCamera& camera) const {
  const RequiredViews& required = options_.required;
  return (reached(camera.views, required.views) + reached(camera.shared_views, required.shared) +
          reached(camera.coverage.share(), required.coverage) +
          reached(camera.tilted_views, required.tilted)) /
         4;
}

BoardCollector::BoardCollector(const Board& board,
                               const std::vector<std::pair<std::string, ImageSize>>& cameras,
                               const Options& options)
    : detector_(board), options_(options), before_(cameras.size()) {
  for (const auto& [name, size] : cameras) {
    cameras_.push_back({name, size, {}, {}, 0, 0, 0, BoardCoverage(size)});
    views_.push_back({name, size.width, size.height, {}});
  }
  shared_.assign(cameras.size(), std::vector<int>(cameras.size(), 0));
}

bool BoardCollector::add(const LiveSet& set) {
  for (std::size_t c = 0; c < cameras_.size(); ++c)
    before_[c] = std::exchange(cameras_[c].seen, std::nullopt);
  const auto look = [&](std::size_t first) {
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
    others.push_back(std::async(std::launch::async, look, static_cast<std::size_t>(i)));
  look(0);
  for (std::future<void>& other : others) other.get();

  const int number = sets_++;
  const bool seen = std::any_of(cameras_.begin(), cameras_.end(), [](const auto& c) { return c.seen; });
  const bool is_new = seen && isNew(), rests = atRest(set);
  unseen_sets_ = seen ? 0 : unseen_sets_ + 1;
  hurried_sets_ = is_new && !rests ? hurried_sets_ + 1 : 0;
  before_s_ = set.time_s;
  if (!is_new || !rests || kept_sets_ >= kMostSets) return false;
  keep(number);
  return true;
}

/// Whether the camera sees enough of the board's corners to tell where it is.
bool BoardCollector::isOfUse(std::size_t camera) const {
  return cameras_[camera].seen && usableView(board(), *cameras_[camera].seen);
}

/// Whether the board, wherever it is seen, moves too slowly for cameras that are out of step to notice.
bool BoardCollector::atRest(const LiveSet& set) const {
  const double passed_s = set.time_s - before_s_;
  if (!(passed_s > 0)) return false;
  const double skew_s = std::max(set.skew_s, options_.unseen_skew_s);
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    if (!cameras_[c].seen) continue;
    if (!before_[c]) return false;
    const std::optional<double> moved_px = distanceBetween(*cameras_[c].seen, *before_[c]);
    if (!moved_px || *moved_px / passed_s * skew_s > kStill_px) return false;
  }
  return true;
}

bool BoardCollector::isNew() const {
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    if (!isOfUse(c)) continue;
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& [number, view] : views_[c].views)
      if (const auto distance = distanceBetween(view, *cameras_[c].seen))
        nearest = std::min(nearest, *distance);
    if (nearest > kElsewhere * cameras_[c].size.width) return true;
  }
  return false;
}

void BoardCollector::keep(int number) {
  std::vector<std::size_t> who;
  for (std::size_t c = 0; c < cameras_.size(); ++c)
    if (isOfUse(c)) who.push_back(c);
  for (const std::size_t c : who) {
    CollectedCamera& camera = cameras_[c];
    views_[c].views[number] = *camera.seen;
    ++camera.views;
    camera.shared_views += who.size() > 1;
    camera.tilted_views += isTilted(board(), *camera.seen);
    for (const Vec2& pixel : camera.seen->pixels) camera.coverage.add(pixel);
    camera.share = shareOf(camera);
    for (const std::size_t other : who) ++shared_[c][other];
  }
  ++kept_sets_;
}

std::optional<int> BoardCollector::keepForWorld() {
  bool of_use = false;
  for (std::size_t c = 0; c < cameras_.size(); ++c) of_use = of_use || isOfUse(c);
  if (!of_use) return std::nullopt;
  const int number = sets_ - 1;
  const bool kept =
      std::any_of(views_.begin(), views_.end(), [&](const auto& of) { return of.views.count(number); });
  if (!kept) keep(number);
  return number;
}

void BoardCollector::clear() {
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    cameras_[c] = {cameras_[c].name, cameras_[c].size, {}, {}, 0, 0, 0, BoardCoverage(cameras_[c].size)};
    views_[c].views.clear();
  }
  for (std::vector<int>& row : shared_) std::fill(row.begin(), row.end(), 0);
  kept_sets_ = 0;
}

/// The cameras that are connected by views that they share, largest group first.
std::vector<std::vector<int>> BoardCollector::groups() const {
  constexpr int kFewestOfPair = 4;
  std::vector<std::vector<int>> groups;
  std::vector<char> placed(cameras_.size(), 0);
  for (std::size_t first = 0; first < cameras_.size(); ++first) {
    if (placed[first]) continue;
    std::vector<int> group = {static_cast<int>(first)};
    placed[first] = 1;
    for (std::size_t i = 0; i < group.size(); ++i)
      for (std::size_t c = 0; c < cameras_.size(); ++c)
        if (!placed[c] && shared_[static_cast<std::size_t>(group[i])][c] >= kFewestOfPair) {
          placed[c] = 1;
          group.push_back(static_cast<int>(c));
        }
    groups.push_back(std::move(group));
  }
  std::sort(groups.begin(), groups.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return groups;
}

double BoardCollector::share() const {
  double sum = 0;
  for (const CollectedCamera& camera : cameras_) sum += camera.share;
  const double cameras = static_cast<double>(cameras_.size());
  return 0.9 * sum / cameras + 0.1 * (groups().size() == 1 ? 1 : 0);
}

bool BoardCollector::enough() const {
  return groups().size() == 1 &&
         std::all_of(cameras_.begin(), cameras_.end(), [](const CollectedCamera& c) { return c.share >= 1; });
}

std::string BoardCollector::advice() const {
  if (enough()) return "that is enough";
  if (unseen_sets_ > kLongUnseen || (sets_ > 0 && kept_sets_ == 0 && unseen_sets_ > 0))
    return "no camera sees the board; hold it into the cube";
  if (hurried_sets_ > kLongHurried) return "hold the board still for a moment, then move on";
  const auto least = std::min_element(cameras_.begin(), cameras_.end(),
                                      [](const auto& a, const auto& b) { return a.share < b.share; });
  const std::string fault = least->fault();
  if (!fault.empty()) {
    const std::string cure = fault == "too dark"     ? "more light on the board would help"
                             : fault == "too bright" ? "less light, or a shorter exposure, would help"
                             : fault == "flat light" ? "a board in black and white, evenly lit, would help"
                                                     : "focus it, or wipe its lens";
    const std::string how = fault == "flat light" ? "has no contrast" : "is " + fault;
    return "the board " + how + " for " + least->name + "; " + cure;
  }
  const std::vector<std::vector<int>> apart = groups();
  if (least->share >= 1 && apart.size() > 1)
    return "hold the board where " + cameras_[static_cast<std::size_t>(apart[1][0])].name + " and " +
           cameras_[static_cast<std::size_t>(apart[0][0])].name + " see it at once";
  if (least->views < options_.required.views)
    return "bring the board before " + least->name + ", here and there";
  if (least->shared_views < options_.required.shared)
    return "hold the board where " + least->name + " and another camera see it at once";
  if (least->coverage.share() < options_.required.coverage) {
    const std::string sides = least->coverage.emptySides();
    return "move the board to where " + least->name + " has not seen it" +
           (sides.empty() ? "" : ": " + sides);
  }
  return "tilt the board before " + least->name + ", by 30 degrees to all sides";
}

}  // namespace airclay
