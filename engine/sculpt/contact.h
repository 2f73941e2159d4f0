// SPDX-License-Identifier: MIT
// The tool *push*, the paper's: the hand displaces the clay. Determines which data points the hand has
// reached, and the target of each.
//
// The hand is a signed distance grid in the hand frame, in which all decisions are made. Between two checks a
// data point moves along a path in that frame: the hand moves from one pose to the next, or the clay from one
// shape to the next.
//
// - A point whose path enters the hand from outside is *reached*, however fast the hand moves and however
// thin it is.
//   Its target is the entry point, which moves with the skin. Its direction, constant in the hand frame,
//   points back along the path.
// - The target of a reached point is on the line through it along its direction: the first surface from
// outside. So it
//   leaves on the side on which it was reached, not on the nearest side. In each new frame the direction
//   turns towards the skin's normal there.
// - It is released once it is outside by kContactReleaseDistance.
// - Points that are inside when tracking starts or the clutch closes are ignored until the hand has left them
// by
//   kContactLeaveDistance.
//
// Contact depends only on motion, so open surfaces, which have no inside, work too.
//
// The smooth surface does not follow its points exactly, so contact, solve and subdivision are repeated
// within the frame. Plain repeats converge slowly: over all rows a single point moves only by its row's entry
// of A A⁺, about a tenth. contact_decide.glsl explains the step size. Points are only pushed outwards, so
// over-relaxation leaves none far from the hand.
//
// Points are in the clay frame (engine/clay/clay.h), in which the symmetry planes are perpendicular to the
// axes; "workspace" means that frame here. The hand's pose is rotated into it at the start of a frame.
#pragma once

#include "engine/sculpt/tool.h"

namespace airclay {

extern const Tool kPushTool;

/// Finds contact on the GPU and keeps the state of each data point from frame to frame.
class ContactFinder {
 public:
  /// `frame` outlives it.
  ContactFinder(Gpu& gpu, const ContactFrame& frame);

  /// Records a check. `first`: right after ContactFrame::recordBegin() with imageCount(mirrors) images;
  /// otherwise after the data points have moved. \pre work recorded before a change of the frame's mirrors is
  /// done
  void recordCheck(Recorder& recorder, const Buffer<vec3>& data_points, bool first);
  /// Records the displacements for the solver, unless the frame is done.
  void recordPush(Recorder& recorder);

  /// All points of image 0, then of image 1, and so on.
  std::vector<GpuContactPoint> points() const { return points_.download(); }

 private:
  Gpu& gpu_;
  const ContactFrame& frame_;
  Kernel<ContactFindArgs> find_;
  Kernel<ContactCheckArgs> check_;
  Kernel<ContactPushArgs> push_;
  Buffer<GpuContactPoint> points_;
};

/// The reference implementation of contact_find: one data point, in double precision.
struct ContactPoint {
  Vec3 position = Vec3::Zero();  ///< at the last check, workspace
  std::uint32_t state = kPointOutside;
  Vec3 direction = Vec3::Zero();  ///< unit, hand frame
  double depth_m = 0, depth_before_m = 0;
  double pushed_m = 0;
};
struct ContactMotion {
  ContactPose before, now;  ///< equal in a frame's repeats
  bool start = false;       ///< tracking starts: points inside are ignored
  bool first = true;        ///< the frame's first check
};
void contactReference(const DistanceGrid& hand, const ContactMotion& motion, const Vec3& data_point,
                      ContactPoint& point);
/// The target of a reached point, workspace.
Vec3 contactTarget(const ContactPose& now, const ContactPoint& point);

}  // namespace airclay
