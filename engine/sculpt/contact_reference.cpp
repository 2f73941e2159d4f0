// SPDX-License-Identifier: MIT
// The reference implementation of contact_find: point by point, in double precision.
#include <algorithm>
#include <limits>
#include <optional>

#include "engine/sculpt/contact.h"

namespace airclay {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Vec3 normalAt(const DistanceGrid& hand, const Vec3& position) {
  Vec3 gradient;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 half = 0.5 * hand.cell_m * Vec3::Unit(axis);
    gradient[axis] = sample(hand, position + half) - sample(hand, position - half);
  }
  return gradient.norm() > 0 ? Vec3(gradient.normalized()) : Vec3(Vec3::UnitZ());
}

/// The path of a data point in the hand frame.
struct Path {
  ContactPose hand_from, hand_to;
  Vec3 point_from, point_to;

  Vec3 at(double t) const {
    Eigen::Vector4d to = hand_to.rotation.coeffs();
    if (to.dot(hand_from.rotation.coeffs()) < 0) to = -to;
    const Eigen::Quaterniond rotation =
        Eigen::Quaterniond(Eigen::Vector4d((1 - t) * hand_from.rotation.coeffs() + t * to)).normalized();
    const Vec3 center = (1 - t) * hand_from.position + t * hand_to.position;
    return rotation.conjugate() * ((1 - t) * point_from + t * point_to - center);
  }
  /// An upper bound of the path's length. The interpolated quaternion turns at most at the rate 4 tan(angle /
  /// 4).
  double bound() const {
    const double turn = 4 * std::tan(hand_from.rotation.angularDistance(hand_to.rotation) / 4);
    const double arm =
        std::max((point_from - hand_from.position).norm(), (point_to - hand_to.position).norm());
    return (point_to - point_from).norm() + (hand_to.position - hand_from.position).norm() + turn * arm;
  }
};

/// The root of `signed_distance` between `from`, where it is positive, and `to`, where it is not.
template <class SignedDistance>
double bisect(const SignedDistance& signed_distance, double from, double to, double tolerance) {
  while (std::abs(to - from) > tolerance) {
    const double middle = (from + to) / 2;
    (signed_distance(middle) > 0 ? from : to) = middle;
  }
  return to;
}

std::optional<double> firstEntry(const DistanceGrid& hand, const Path& path, bool leaves) {
  const auto distance = [&](double t) { return sample(hand, path.at(t)); };
  const double length = path.bound();
  if (!leaves && distance(0) <= 0) return 0;
  if (length <= 0 || distance(0) > length) return std::nullopt;
  const double min_step = std::max<double>(kContactMinStep, length / kContactMaxSteps);
  double t = 0, before = 0;
  for (;;) {
    const double here = distance(t);
    if (!leaves && here <= 0) return bisect(distance, before, t, kContactTolerance / length);
    if (leaves) leaves = here <= kContactReleaseDistance;
    if (t >= 1) return std::nullopt;
    before = t;
    t = std::min(1.0, t + std::max(leaves ? 0.0 : here, min_step) / length);
  }
}

/// The first surface along the line from `high` down to `low`. Infinite if no point above it is outside;
/// empty if there is no surface.
std::optional<double> firstSurface(const DistanceGrid& hand, const Vec3& position, const Vec3& direction,
                                   double high, double low) {
  const auto distance = [&](double s) { return sample(hand, position + s * direction); };
  double s = high;
  for (; distance(s) <= 0; s += std::max<double>(-distance(s), kContactMinStep))
    if (s > high + kContactMaxClimb) return kInfinity;
  double before = s;
  for (; distance(s) > 0; s = std::max(low, s - std::max<double>(distance(s), kContactMinStep))) {
    if (s <= low) return std::nullopt;
    before = s;
  }
  return bisect(distance, before, s, kContactTolerance);
}

void sweep(const DistanceGrid& hand, const Path& path, bool leaves, ContactPoint& point) {
  point.state = kPointOutside;
  point.depth_m = 0;
  const std::optional<double> t = firstEntry(hand, path, leaves);
  if (!t) return;
  Vec3 back = path.at(*t) - path.at(1);
  point.state = kPointReached;
  point.depth_m = point.depth_before_m = back.norm();
  if (point.depth_m <= kContactMinPath) back = path.at(0) - path.at(1);  // entered at the very end
  point.direction = back.norm() > 0 ? Vec3(back.normalized()) : Vec3(Vec3::UnitZ());
  point.pushed_m = 0;
}

void follow(const DistanceGrid& hand, const Path& path, bool first, ContactPoint& point) {
  const Vec3 from = path.at(0), to = path.at(1);
  if (first) point.direction = (point.direction + kContactTurnToNormal * normalAt(hand, from)).normalized();
  const double high =
      std::max(0.0, (from - to).dot(point.direction)) + std::max(0.0, point.depth_m) + kContactLift;
  point.depth_before_m = point.depth_m;
  const std::optional<double> surface = firstSurface(hand, to, point.direction, high, -point.pushed_m);
  point.depth_m = surface.value_or(-point.pushed_m);
  if (point.depth_m == kInfinity) {
    point.state = kPointIgnored;
    point.depth_m = 0;
  } else if (!surface && point.pushed_m == 0 && sample(hand, to) > kContactReleaseDistance) {
    sweep(hand, path, true, point);
  }
}

}  // namespace

void contactReference(const DistanceGrid& hand, const ContactMotion& motion, const Vec3& data_point,
                      ContactPoint& point) {
  const Path path{motion.before, motion.now, point.position, data_point};
  point.position = data_point;
  if (motion.first) point.pushed_m = 0;
  const double distance = sample(hand, path.at(1));
  if (motion.start) {
    point.state = distance <= 0 ? kPointIgnored : kPointOutside;
    point.depth_m = 0;
  } else if (point.state == kPointIgnored) {
    if (distance > kContactLeaveDistance) point.state = kPointOutside;
  } else if (point.state == kPointReached) {
    follow(hand, path, motion.first, point);
  } else {
    sweep(hand, path, false, point);
  }
}

Vec3 contactTarget(const ContactPose& now, const ContactPoint& point) {
  return point.position + now.rotation * (point.depth_m * point.direction);
}

}  // namespace airclay
