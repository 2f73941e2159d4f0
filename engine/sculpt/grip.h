// SPDX-License-Identifier: MIT
// The tool *pull*: touched clay sticks to the hand and follows it.
//
// The hand grabs the data points within its reach of the skin, or inside it, in the first held frame in which
// there are any. From then on it holds these and no others, each at its place in the hand's frame, until the
// clutch opens, the tool or the symmetry changes, or tracking is lost. So the grip is known from the moment
// the clutch closes on the clay: a hand that moves on gathers no more, and there is no time window whose end
// depends on the frame rate.
//
// The targets of the held points pull the rest along by the same repeats of solve and subdivision as in
// engine/sculpt/contact.h, with vectors in place of depths. Among the shapes that put the held points
// there the repeats approach the one whose data points move least, which leaves the far side alone.
#pragma once

#include "engine/sculpt/tool.h"
#include "shaders/sculpt/grip_io.h"

namespace airclay {

extern const Tool kPullTool;

/// Holds clay on the GPU.
class Grip {
 public:
  /// `frame` outlives it.
  Grip(Gpu& gpu, const ContactFrame& frame);

  /// Records which points are held and how far each lags behind, and a check of the lag. `first`: right after
  /// ContactFrame::recordBegin(); otherwise after the data points have moved.
  void recordCheck(Recorder& recorder, const Buffer<vec3>& data_points, bool first,
                   double reach_m = kGripReach_m);
  /// Records the displacements for the solver, unless the frame is done.
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
                            const Vec3& data_point, double reach_m = kGripReach_m);
/// The target of a data point that was at `start` when the hand grabbed it at `gripped`, workspace.
Vec3 gripTarget(const ContactPose& gripped, const ContactPose& now, std::uint32_t mirrors,
                std::uint32_t images, const Vec3& start);

}  // namespace airclay
