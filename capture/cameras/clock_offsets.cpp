// SPDX-License-Identifier: MIT
// Rays on a fine common grid of times, by local quadratic fits, so that an offset is a shift of the grid;
// how steady their distance is for each shift; a parabola about the best.
#include "capture/cameras/clock_offsets.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/core/error.h"
#include "engine/core/median.h"

namespace airclay {
namespace {

// Steps of the grid a frame: the parabola does the rest.
constexpr int kStepsPerFrame = 8;
// The width of the local fits, in frames: some five frames make a place. Narrower leaves noise.
constexpr double kWidthFrames = 1.2;
constexpr double kLeastSeconds = 3;
// A pair tells its offset only if that makes the distance so much steadier than others do, in variance ...
constexpr double kLeastGain = 4;
// ... and no offset elsewhere comes so near to it.
constexpr double kRivalGain = 2;
// An hour at 30 Hz is less; what is more is no recording of a waving hand.
constexpr double kMostSteps = 1e6;

/// A camera's rays at the grid's times.
struct Rays {
  Vec3 centre = Vec3::Zero();  ///< of the camera, world
  std::vector<Vec3> at;        ///< directions, world, unit; NaN where it saw nothing
};

struct Grid {
  double first_s = 0, step_s = 0;
  long count = 0;
};

struct Range {
  long begin, end;  ///< of the grid
};

double medianPeriod(const std::vector<double>& times_s) {
  std::vector<double> periods;
  for (std::size_t i = 1; i < times_s.size(); ++i) periods.push_back(times_s[i] - times_s[i - 1]);
  return median(std::move(periods));
}

/// The value at `time_s` of the quadratic that fits the centroids around it best, weighted by a Gaussian.
/// Local fits need no even times (Fan and Gijbels 1996, 3.1).
std::optional<Vec2> centroidAt(const MotionSeries& series, double time_s, double width_s) {
  const auto first = std::lower_bound(series.times_s.begin(), series.times_s.end(), time_s - 3 * width_s);
  Mat3 normal = Mat3::Zero();
  Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
  int count = 0;
  double before = 0, after = 0;
  for (auto at = first; at != series.times_s.end() && *at <= time_s + 3 * width_s; ++at, ++count) {
    const double x = (*at - time_s) / width_s, weight = std::exp(-0.5 * x * x);
    const Vec3 powers(1, x, x * x);
    const Vec2& centroid = series.centroid_px[static_cast<std::size_t>(at - series.times_s.begin())];
    normal += weight * powers * powers.transpose();
    right += weight * powers * centroid.transpose();
    before = std::min(before, x), after = std::max(after, x);
  }
  if (count < 5 || before > -1 || after < 1) return std::nullopt;  // it would be an extrapolation
  return Vec2(normal.ldlt().solve(right).row(0).transpose());
}

Rays raysOf(const Camera& camera, const MotionSeries& series, const Grid& grid, double width_s) {
  const Pose world_from_camera = camera.camera_from_world.inverse();
  Rays rays;
  rays.centre = world_from_camera.translation();
  rays.at.assign(static_cast<std::size_t>(grid.count), Vec3::Constant(NAN));
  for (long i = 0; i < grid.count; ++i) {
    const auto pixel = centroidAt(series, grid.first_s + grid.step_s * static_cast<double>(i), width_s);
    const auto direction = pixel ? rayThroughPixel(camera.lens, *pixel) : std::nullopt;
    if (direction) rays.at[static_cast<std::size_t>(i)] = world_from_camera.linear() * *direction;
  }
  return rays;
}

/// The variance of the distance between the rays a(i) and b(i + shift); infinite where they have too little
/// in common.
double unsteadiness(const Rays& a, const Rays& b, long shift, Range range) {
  double sum_m = 0, squares_m2 = 0, count = 0;
  const Vec3 base = b.centre - a.centre;
  const long end = std::min(range.end, static_cast<long>(b.at.size()) - shift);
  for (long i = std::max(range.begin, -shift); i < end; ++i) {
    const Vec3 normal = a.at[static_cast<std::size_t>(i)].cross(b.at[static_cast<std::size_t>(i + shift)]);
    const double distance_m = base.dot(normal) / normal.norm();
    if (!std::isfinite(distance_m)) continue;
    sum_m += distance_m, squares_m2 += distance_m * distance_m, ++count;
  }
  if (count < 0.4 * static_cast<double>(range.end - range.begin)) return INFINITY;
  return std::max(0.0, squares_m2 / count - sum_m * sum_m / (count * count));
}

/// What a pair of cameras tells.
struct PairOffset {
  double offset_s = 0;  ///< b's clock - a's
  double weight = 0;    ///< the inverse of its variance, but for a factor; 0: it tells nothing
  bool repeats = false;
};

PairOffset offsetOf(const Rays& a, const Rays& b, const Grid& grid, Range range, long most) {
  std::vector<double> costs;
  for (long shift = -most; shift <= most; ++shift) costs.push_back(unsteadiness(a, b, shift, range));
  const auto cost = [&](long i) { return costs[static_cast<std::size_t>(i)]; };
  const long best = std::min_element(costs.begin(), costs.end()) - costs.begin();
  PairOffset pair;
  if (!std::isfinite(cost(best))) return pair;

  // A parabola by least squares through the steps of half a frame to both sides.
  constexpr long half = kStepsPerFrame / 2;
  const long middle = std::clamp(best, half, 2 * most - half);
  Mat3 normal = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (long i = -half; i <= half; ++i) {
    if (!std::isfinite(cost(middle + i))) return pair;
    const double x = static_cast<double>(i);
    const Vec3 powers(1, x, x * x);
    normal += powers * powers.transpose();
    right += powers * cost(middle + i);
  }
  const Vec3 parabola = normal.ldlt().solve(right);
  if (!(parabola.z() > 0)) return pair;
  const double lowest = std::clamp(-parabola.y() / (2 * parabola.z()), -double(half), double(half));
  pair.offset_s = (static_cast<double>(middle - most) + lowest) * grid.step_s;

  // Up from the valley to both sides; what lies beyond the hills and is as low is a rival.
  long left = best, beyond = best;
  while (left > 0 && cost(left - 1) >= cost(left)) --left;
  while (beyond < 2 * most && cost(beyond + 1) >= cost(beyond)) ++beyond;
  double rival = INFINITY;
  for (long i = 0; i <= 2 * most; ++i)
    if (i < left || i > beyond) rival = std::min(rival, cost(i));
  const double least = std::max(cost(best), 1e-12);  // a micrometre, squared: not from pixels
  std::vector<double> sorted = costs;
  std::sort(sorted.begin(), sorted.end());
  const bool moves = sorted[sorted.size() / 2] > kLeastGain * least;
  pair.repeats = moves && rival < kRivalGain * least;
  if (moves && !pair.repeats) pair.weight = parabola.z() / least;
  return pair;
}

using Pairs = std::vector<std::vector<PairOffset>>;  ///< [a][b], a < b

Pairs allPairs(const std::vector<Rays>& cameras, const Grid& grid, Range range, double max_offset_s) {
  Pairs pairs(cameras.size(), std::vector<PairOffset>(cameras.size()));
  const long most = std::max(std::lround(max_offset_s / grid.step_s), long{kStepsPerFrame});
  for (std::size_t a = 0; a < cameras.size(); ++a)
    for (std::size_t b = a + 1; b < cameras.size(); ++b)
      pairs[a][b] = offsetOf(cameras[a], cameras[b], grid, range, most);
  return pairs;
}

/// The offsets that agree best with all pairs', camera 0's being 0.
std::vector<double> solvePairs(const Pairs& pairs) {
  const auto count = static_cast<Eigen::Index>(pairs.size());
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(count, count);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(count);
  for (Eigen::Index a = 0; a < count; ++a)
    for (Eigen::Index b = a + 1; b < count; ++b) {
      const PairOffset& pair = pairs[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)];
      normal(a, a) += pair.weight, normal(b, b) += pair.weight;
      normal(a, b) -= pair.weight, normal(b, a) -= pair.weight;
      right(b) += pair.weight * pair.offset_s, right(a) -= pair.weight * pair.offset_s;
    }
  normal(0, 0) += std::max(normal.diagonal().maxCoeff(), 1.0);
  const Eigen::VectorXd offsets = normal.completeOrthogonalDecomposition().solve(right);
  std::vector<double> result;
  for (Eigen::Index c = 0; c < count; ++c) result.push_back(offsets(c) - offsets(0));
  return result;
}

/// Each camera must be tied to the first one by pairs that tell something.
void checkTied(const Pairs& pairs, const Rig& rig) {
  std::vector<bool> tied(pairs.size(), false);
  tied[0] = true;
  for (std::size_t round = 0; round < pairs.size(); ++round)
    for (std::size_t a = 0; a < pairs.size(); ++a)
      for (std::size_t b = a + 1; b < pairs.size(); ++b)
        if (pairs[a][b].weight > 0 && tied[a] != tied[b]) tied[a] = tied[b] = true;
  for (std::size_t c = 1; c < pairs.size(); ++c) {
    if (tied[c]) continue;
    bool repeats = false;
    for (std::size_t a = 0; a < c; ++a) repeats |= pairs[a][c].repeats;
    throw Error("the clock of camera \"" + rig.cameras[c].name + "\" cannot be told: " +
                (repeats ? "the motion repeats itself, so that several offsets fit; an irregular one"
                         : "it did not see one motion with the others; one hand that moves freely") +
                ", for 10 s before all cameras, would be right");
  }
}

void checkSeries(const MotionSeries& series, const std::string& name) {
  const std::string who = "the clock of camera \"" + name + "\" cannot be told: ";
  if (series.times_s.size() != series.centroid_px.size() || series.times_s.size() < 10 ||
      series.times_s.back() - series.times_s.front() < kLeastSeconds)
    throw Error(who +
                "it saw the hand for too short; a hand that moves freely for 10 s before all cameras "
                "would be right");
  if (!std::is_sorted(series.times_s.begin(), series.times_s.end()))
    throw Error(who + "its times run back; growing times would be right");
}

}  // namespace

ClockOffsets estimateClockOffsets(const Rig& rig, const std::vector<MotionSeries>& cameras,
                                  const ClockOffsetOptions& options) {
  double first_s = INFINITY, last_s = -INFINITY, period_s = 0;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    checkSeries(cameras[c], rig.cameras[c].name);
    first_s = std::min(first_s, cameras[c].times_s.front());
    last_s = std::max(last_s, cameras[c].times_s.back());
    period_s = std::max(period_s, medianPeriod(cameras[c].times_s));
  }
  Grid grid{first_s, period_s / kStepsPerFrame, 0};
  if (!(grid.step_s > 0) || (last_s - first_s) / grid.step_s > kMostSteps)
    throw Error("the clocks cannot be told from so long a recording; some 10 s would be right");
  grid.count = static_cast<long>((last_s - first_s) / grid.step_s) + 1;
  std::vector<Rays> rays;
  for (std::size_t c = 0; c < cameras.size(); ++c)
    rays.push_back(raysOf(rig.cameras[c], cameras[c], grid, kWidthFrames * period_s));

  const Pairs pairs = allPairs(rays, grid, {0, grid.count}, options.max_offset_s);
  checkTied(pairs, rig);
  ClockOffsets result;
  result.offset_s = solvePairs(pairs);
  result.deviation_s.assign(cameras.size(), 0);
  for (long third = 0; third < 3; ++third) {
    const Range range{third * grid.count / 3, (third + 1) * grid.count / 3};
    const std::vector<double> offsets_s = solvePairs(allPairs(rays, grid, range, options.max_offset_s));
    // The mean of three has a third of the variance of one; of which we have two degrees of freedom.
    for (std::size_t c = 0; c < cameras.size(); ++c)
      result.deviation_s[c] += std::pow(offsets_s[c] - result.offset_s[c], 2) / 2 / 3;
  }
  for (double& deviation_s : result.deviation_s) deviation_s = std::sqrt(deviation_s);
  return result;
}

}  // namespace airclay
