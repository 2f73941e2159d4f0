// SPDX-License-Identifier: MIT
// The tool *pull*: touched clay sticks to the hand and follows it.
//
// The hand grabs the data points inside it or within reach of its skin, in the first held frame in which
// there are any. From then on it holds exactly these, each at a fixed position in the hand frame, until the
// clutch opens, the tool or the symmetry changes, or tracking is lost. The set of held points is thus fixed
// when the clutch closes on the clay: a moving hand collects no further points, and no time window depends on
// the frame rate.
//
// The targets of the held points pull the other points along, by the same repeats of solve and subdivision as
// in engine/sculpt/contact.h, with vectors instead of depths. Of all shapes with the held points at their
// targets, the repeats approach the one whose data points move least, which leaves the far side unchanged.
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

  /// Records the search for held points, their lag, and a check of the lag. `first`: right after
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

/// The reference implementation of grip_find, in double precision: the images that hold a data point, bit k
/// for image k.
std::uint32_t gripReference(const DistanceGrid& hand, const ContactPose& now, std::uint32_t mirrors,
                            const Vec3& data_point, double reach_m = kGripReach_m);
/// The target, in the workspace frame, of a data point that was at `start` when the hand grabbed it at pose
/// `gripped`.
Vec3 gripTarget(const ContactPose& gripped, const ContactPose& now, std::uint32_t mirrors,
                std::uint32_t images, const Vec3& start);

}  // namespace airclay
