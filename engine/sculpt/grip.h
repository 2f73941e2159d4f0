// SPDX-License-Identifier: MIT
// The tool *pull*: touched clay sticks to the hand and follows it.
//
// The hand takes hold of the data points within kGripReach_m of its skin, or inside it, in the first held
// frame in which there are any. From then on it holds these and no others, each at its place in the hand's
// frame, until the clutch opens, the tool or the symmetry changes, or tracking is lost. So what is in the
// grip is known from the moment the clutch closes on the clay: a hand that moves on gathers no more, and
// there is no window of time whose end depends on the frame rate.
//
// Where the held points have to go, they pull the rest along by the same repeats of solve and subdivision as
// in engine/sculpt/contact.h, with vectors in place of depths. Among the shapes that put the held points
// there the repeats approach the one whose data points move the least, which leaves the far side alone.
#pragma once

#include "engine/sculpt/contact.h"
#include "shaders/sculpt/grip_io.h"

namespace airclay {

/// Holds clay on the GPU.
class Grip {
 public:
  /// `frame` outlives it.
  Grip(Gpu& gpu, const ContactFrame& frame);

  /// Records who is held and how far each lags behind, and the check of that. `first`: of the frame, after
  /// ContactFrame::recordBegin; later on: after the data points have moved, when the frame is not done.
  void recordCheck(Recorder& recorder, const Buffer<vec3>& data_points, std::uint32_t mirrors, bool first);
  /// Records the displacements wanted, when the frame is not done.
  void recordPull(Recorder& recorder);

  std::vector<GpuGripPoint> points() const { return points_.download(); }

 private:
  const ContactFrame& frame_;
  Kernel<GripFindArgs> find_;
  Kernel<GripCheckArgs> check_;
  Kernel<GripPullArgs> pull_;
  Buffer<GpuGripPoint> points_;
};

/// The twins of grip_find, in double precision. The images that hold a data point: bit k for image k.
std::uint32_t gripReference(const DistanceGrid& hand, const ContactPose& now, std::uint32_t mirrors,
                            const Vec3& data_point);
/// Where a data point that was at `start` when the hand took hold at `gripped` is to be, workspace.
Vec3 gripTarget(const ContactPose& gripped, const ContactPose& now, std::uint32_t mirrors,
                std::uint32_t images, const Vec3& start);

}  // namespace airclay
