// SPDX-License-Identifier: MIT
#include "capture/takes/truth.h"

#include <algorithm>
#include <cmath>

#include "engine/core/error.h"

namespace airclay {
namespace {

/// The first pose that is not before `time_s`.
auto firstFrom(const std::vector<TimedPose>& poses, double time_s) {
  return std::lower_bound(poses.begin(), poses.end(), time_s,
                          [](const TimedPose& pose, double time) { return pose.time_s < time; });
}

}  // namespace

std::optional<Pose> nearestPose(const std::vector<TimedPose>& poses, double time_s, double frame_s) {
  const auto after = firstFrom(poses, time_s);
  const TimedPose* nearest = nullptr;
  const auto consider = [&](const TimedPose& pose) {
    if (!nearest || std::abs(pose.time_s - time_s) < std::abs(nearest->time_s - time_s)) nearest = &pose;
  };
  if (after != poses.end()) consider(*after);
  if (after != poses.begin()) consider(*std::prev(after));
  if (!nearest || std::abs(nearest->time_s - time_s) > frame_s / 2) return std::nullopt;
  return nearest->world_from_hand;
}

std::optional<Pose> interpolatedPose(const std::vector<TimedPose>& poses, double time_s, double gap_s) {
  const auto after = firstFrom(poses, time_s);
  if (after == poses.end()) return std::nullopt;
  if (after->time_s == time_s) return after->world_from_hand;
  if (after == poses.begin()) return std::nullopt;
  const TimedPose &from = *std::prev(after), &to = *after;
  if (to.time_s - from.time_s > gap_s) return std::nullopt;
  const double t = (time_s - from.time_s) / (to.time_s - from.time_s);
  const Eigen::Quaterniond start(Mat3(from.world_from_hand.linear())), end(Mat3(to.world_from_hand.linear()));
  Pose pose = Pose::Identity();
  pose.linear() = start.slerp(t, end).toRotationMatrix();
  pose.translation() = (1 - t) * from.world_from_hand.translation() + t * to.world_from_hand.translation();
  return pose;
}

std::optional<Pose> Truth::at(double time_s, double frame_s) const {
  const std::optional<Pose> of_frame = nearestPose(frames, time_s, frame_s);
  if (!of_frame) return std::nullopt;
  const std::optional<Pose> between = interpolatedPose(dense, time_s, 1.5 * frame_s);
  return between ? between : of_frame;
}

Truth readTruth(const std::filesystem::path& take) {
  if (!std::filesystem::is_directory(take))
    throw Error(take.string() + ": there is no such take; expected a folder with truth.tum");
  if (!std::filesystem::exists(take / "truth.tum"))
    throw Error(take.string() + ": the take has no ground truth; expected truth.tum, a TUM trajectory");
  Truth truth{readPoses(take / "truth.tum"), {}};
  if (const auto dense = take / "truth_dense.tum"; std::filesystem::exists(dense))
    truth.dense = readPoses(dense);
  return truth;
}

}  // namespace airclay
