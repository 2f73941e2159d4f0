// SPDX-License-Identifier: MIT
// Interpolates rays on a fine common time grid by local quadratic fits, so that an offset is a shift of the
// grid; computes the variance of their distance for each shift; and fits a parabola around the minimum.
#include "capture/cameras/clock_offsets.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/core/error.h"
#include "engine/core/median.h"

namespace airclay {
namespace {

// Grid steps per frame; the parabola refines further.
constexpr int kStepsPerFrame = 8;
// The width of the local fits, in frames: about five frames contribute to a position. Narrower fits leave
// noise.
constexpr double kWidthFrames = 1.2;
constexpr double kMinDurationS = 3;
// A pair determines its offset only if it reduces the variance by this factor compared with other offsets …
constexpr double kMinGain = 4;
// … and no separate minimum is within this factor.
constexpr double kRivalGain = 2;
// An hour at 30 Hz is less; more is not a recording of a waving hand.
constexpr double kMaxSteps = 1e6;

/// A camera's rays at the grid times.
struct Rays {
  Vec3 centre = Vec3::Zero();  ///< of the camera, world
  std::vector<Vec3> at;        ///< unit directions, world; NaN where the camera does not see the hand
};

struct Grid {
  double first_s = 0, step_s = 0;
  long count = 0;
};

struct Range {
  long begin, end;  ///< grid indices
};

double medianPeriod(const std::vector<double>& times_s) {
  std::vector<double> periods;
  for (std::size_t i = 1; i < times_s.size(); ++i) periods.push_back(times_s[i] - times_s[i - 1]);
  return median(std::move(periods));
}

/// The value at `time_s` of the quadratic that best fits the centroids around it, weighted by a Gaussian.
/// Local fits do not require uniform times (Fan and Gijbels 1996, 3.1).
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
  if (count < 5 || before > -1 || after < 1) return std::nullopt;  // would extrapolate
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

/// The variance of the distance between the rays a(i) and b(i + shift); infinite if they overlap too little.
double distanceVariance(const Rays& a, const Rays& b, long shift, Range range) {
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

/// The estimate from one pair of cameras.
struct PairOffset {
  double offset_s = 0;  ///< b's clock - a's
  double weight = 0;    ///< proportional to the inverse variance; 0: undetermined
  bool repeats = false;
};

PairOffset offsetOf(const Rays& a, const Rays& b, const Grid& grid, Range range, long most) {
  std::vector<double> costs;
  for (long shift = -most; shift <= most; ++shift) costs.push_back(distanceVariance(a, b, shift, range));
  const auto cost = [&](long i) { return costs[static_cast<std::size_t>(i)]; };
  const long best = std::min_element(costs.begin(), costs.end()) - costs.begin();
  PairOffset pair;
  if (!std::isfinite(cost(best))) return pair;

  // A least-squares parabola through the steps within half a frame on both sides.
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

  // The valley around the minimum; a similarly low value outside it is a rival.
  long left = best, beyond = best;
  while (left > 0 && cost(left - 1) >= cost(left)) --left;
  while (beyond < 2 * most && cost(beyond + 1) >= cost(beyond)) ++beyond;
  double rival = INFINITY;
  for (long i = 0; i <= 2 * most; ++i)
    if (i < left || i > beyond) rival = std::min(rival, cost(i));
  const double least = std::max(cost(best), 1e-12);  // (1 µm)²: below the resolution of pixels
  std::vector<double> sorted = costs;
  std::sort(sorted.begin(), sorted.end());
  const bool moves = sorted[sorted.size() / 2] > kMinGain * least;
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

/// The offsets that best fit all pairs, with camera 0 at 0.
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

/// \throw Error unless each camera is connected to the first one by pairs with a weight.
void checkConnected(const Pairs& pairs, const Rig& rig) {
  std::vector<bool> connected(pairs.size(), false);
  connected[0] = true;
  for (std::size_t round = 0; round < pairs.size(); ++round)
    for (std::size_t a = 0; a < pairs.size(); ++a)
      for (std::size_t b = a + 1; b < pairs.size(); ++b)
        if (pairs[a][b].weight > 0 && connected[a] != connected[b]) connected[a] = connected[b] = true;
  for (std::size_t c = 1; c < pairs.size(); ++c) {
    if (connected[c]) continue;
    bool repeats = false;
    for (std::size_t a = 0; a < c; ++a) repeats |= pairs[a][c].repeats;
    throw Error("the clock offset of camera \"" + rig.cameras[c].name + "\" cannot be determined: " +
                (repeats ? "the motion is periodic, so that several offsets fit; expected an irregular motion"
                         : "it did not see the same motion as the others; expected one freely moving hand") +
                ", in front of all cameras for 10 s");
  }
}

void checkSeries(const MotionSeries& series, const std::string& name) {
  const std::string prefix = "the clock offset of camera \"" + name + "\" cannot be determined: ";
  if (series.times_s.size() != series.centroid_px.size() || series.times_s.size() < 10 ||
      series.times_s.back() - series.times_s.front() < kMinDurationS)
    throw Error(prefix +
                "it saw the hand for too short a time; expected a freely moving hand in front of all cameras "
                "for 10 s");
  if (!std::is_sorted(series.times_s.begin(), series.times_s.end()))
    throw Error(prefix + "its times run backwards; expected increasing times");
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
  if (!(grid.step_s > 0) || (last_s - first_s) / grid.step_s > kMaxSteps)
    throw Error("the recording is too long to determine clock offsets; expected about 10 s");
  grid.count = static_cast<long>((last_s - first_s) / grid.step_s) + 1;
  std::vector<Rays> rays;
  for (std::size_t c = 0; c < cameras.size(); ++c)
    rays.push_back(raysOf(rig.cameras[c], cameras[c], grid, kWidthFrames * period_s));

  const Pairs pairs = allPairs(rays, grid, {0, grid.count}, options.max_offset_s);
  checkConnected(pairs, rig);
  ClockOffsets result;
  result.offset_s = solvePairs(pairs);
  result.deviation_s.assign(cameras.size(), 0);
  for (long third = 0; third < 3; ++third) {
    const Range range{third * grid.count / 3, (third + 1) * grid.count / 3};
    const std::vector<double> offsets_s = solvePairs(allPairs(rays, grid, range, options.max_offset_s));
    // Sample variance with two degrees of freedom, divided by 3 for the mean of three.
    for (std::size_t c = 0; c < cameras.size(); ++c)
      result.deviation_s[c] += std::pow(offsets_s[c] - result.offset_s[c], 2) / 2 / 3;
  }
  for (double& deviation_s : result.deviation_s) deviation_s = std::sqrt(deviation_s);
  return result;
}

}  // namespace airclay
