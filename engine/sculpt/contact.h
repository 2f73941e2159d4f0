// SPDX-License-Identifier: MIT
// The tool *push*, the paper's: the clay gives way to the hand. Which data points has the hand reached, and
// where does each have to go?
//
// The hand is a signed distance grid in its own frame, and everything is decided in that frame. Between two
// checks a data point has a path in the hand's frame: the hand moves from one pose to the next, or the clay
// from one shape to the next.
//
// - A point whose path enters the hand from outside is *reached*, however fast the hand moves and however
// thin it
//   is. Its target is where it entered, carried along by the skin that hit it. Its direction, constant in the
//   hand's frame, points back along the path.
// - A reached point's target is on the line through it along its direction: the first surface met from
// outside. So
//   it leaves by the side on which it was reached, never by the nearest one. In each new frame the direction
//   turns towards the skin's normal there.
// - It is released once it is outside by kContactReleased.
// - Points that are inside when tracking starts or the clutch closes are ignored until the hand has left them
// by
//   kContactLeft.
//
// Motion alone decides, so open sheets, which have no inside, work as well.
//
// The smooth surface does not follow its points exactly, so contact, solve and subdivision are repeated
// within the frame. Plain repeats converge slowly: over all rows a single point moves only by its row's entry
// of A A⁺, about a tenth. contact_decide.glsl explains the choice of the step. Points are only ever pushed
// outwards, so none ends far off the hand because of it.
//
// Points are in the clay's own frame (engine/clay/clay.h), in which the planes of symmetry are those of the
// axes: "workspace" means that frame here. The hand's pose is rotated into it when a frame begins.
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
  /// otherwise after the data points have moved. \pre nothing recorded before a change of the frame's mirrors
  /// is still running
  void recordCheck(Recorder& recorder, const Buffer<vec3>& data_points, bool first);
  /// Records the displacements for the solver, unless the frame is done.
  void recordPush(Recorder& recorder);

  /// Those of image 0 first.
  std::vector<GpuContactPoint> points() const { return points_.download(); }

 private:
  Gpu& gpu_;
  const ContactFrame& frame_;
  Kernel<ContactFindArgs> find_;
  Kernel<ContactCheckArgs> check_;
  Kernel<ContactPushArgs> push_;
  Buffer<GpuContactPoint> points_;
};

/// The twin of contact_find, for one data point, serial, in double precision.
struct ContactPoint {
  Vec3 position = Vec3::Zero();  ///< at the last check, workspace
  std::uint32_t state = kPointOutside;
  Vec3 direction = Vec3::Zero();  ///< hand's frame
  double depth_m = 0, depth_before_m = 0;
  double pushed_m = 0;
};
struct ContactMotion {
  ContactPose before, now;  ///< equal in a frame's repeats
  bool start = false;       ///< tracking begins: points inside are ignored
  bool first = true;        ///< check of the frame
};
void contactReference(const DistanceGrid& hand, const ContactMotion& motion, const Vec3& data_point,
                      ContactPoint& point);
/// The target of a reached point, workspace.
Vec3 contactTarget(const ContactPose& now, const ContactPoint& point);

}  // namespace airclay
