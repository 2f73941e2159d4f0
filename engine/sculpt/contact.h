// SPDX-License-Identifier: MIT
// Contact: which data points the hand has reached, and where each has to go.
//
// The hand is a signed distance grid in its own frame, and everything is decided there. Between two checks a
// data point has a way in the hand's frame: the hand goes from one pose to the next, or the clay from one
// shape to the next.
//
// - A point that was outside and whose way enters the hand has been reached, however fast the hand was and
// however thin it is: it is to go back to
//   where it entered, carried along by the piece of skin that hit it. Its direction, kept in the hand's
//   frame, is the way back.
// - A reached point has its place on the line through it along its direction: the first surface met from
// outside. So it leaves by the
//   side on which it was reached, never by the nearest one. With each new frame the direction turns towards
//   the skin's normal there.
// - It is released once it is outside by kContactReleased.
// - Points that are inside when tracking or the clutch starts are ignored until the hand has left them by
// kContactLeft.
//
// Motion alone decides, so open sheets, which have no inside, need none.
//
// The smooth surface does not follow its points exactly, so contact, solve and subdivision are repeated
// within the frame. Plain repeats converge slowly: over all rows a lone point gets only the share of its way
// that is its row's entry of A A⁺, about a tenth. contact_check.comp tells how the step is chosen instead;
// points are only ever pushed, so none ends far off the hand for it.
//
// All that is told of the clay here is in its own frame (engine/clay/clay.h), where the planes of symmetry
// are those of the axes: "workspace" means that frame, into which the hand's pose is turned when a frame
// begins.
#pragma once

#include "engine/gpu/kernel.h"
#include "engine/gpu/recorder.h"
#include "engine/mesh/distance_grid.h"
#include "engine/sculpt/symmetry.h"
#include "shaders/sculpt/contact_io.h"

namespace airclay {

/// The hand's distances for contact_find: 2.5 mm cells, 30 mm around it, about the solid's centre of gravity.
DistanceGrid contactGrid(const TriangleMesh& skin);

/// What all tools share of a frame on the GPU: where the hand was and is, how the repeats go, and what is
/// wanted of the solve.
class ContactFrame {
 public:
  /// `hand` is about the centre of gravity, axes of the hand's frame. `project_groups` and `apply_groups` are
  /// the workgroups of the solve that the repeats dispatch.
  ContactFrame(Gpu& gpu, const DistanceGrid& hand, std::uint32_t data_point_count,
               std::uint32_t project_groups, std::uint32_t apply_groups);

  /// Starts a frame: element 0 of `fit` is the hand, `held` the clutch. `images` of each data point are
  /// looked at in workgroups of their own.
  void recordBegin(Recorder& recorder, const Buffer<GpuFit>& fit, bool held, std::uint32_t images = 1);
  /// From the next frame on. When it changes, that has to start anew.
  void setClayFromWorkspace(const Eigen::Quaterniond& clay_from_workspace) {
    clay_from_workspace_ = clay_from_workspace;
  }
  /// The next frame starts anew, as if tracking began.
  void forget() { forget_ = true; }

  const Buffer<GpuContactFrame>& state() const { return state_; }
  /// One a data point, in the workspace, metres; zero where nothing is wanted.
  const Buffer<vec3>& displacements() const { return displacements_; }
  std::uint32_t dataPointCount() const { return static_cast<std::uint32_t>(displacements_.count()); }
  HandDistances hand() const;
  /// For a check that ends the repeats at `target_m`, or after so many.
  ContactDecision decision(float target_m, std::uint32_t max_repeats,
                           std::uint32_t max_stalls = kContactMaxStalls) const;

  /// The groups of what a repeat dispatches: 0 when the frame is done.
  const RawBuffer& groups() const { return state_.raw(); }
  static constexpr std::uint64_t kFindGroups = offsetof(GpuContactFrame, find_groups);
  static constexpr std::uint64_t kPointGroups = offsetof(GpuContactFrame, point_groups);
  static constexpr std::uint64_t kProjectGroups = offsetof(GpuContactFrame, project_groups);
  static constexpr std::uint64_t kApplyGroups = offsetof(GpuContactFrame, apply_groups);
  static constexpr std::uint64_t kCheckGroups = offsetof(GpuContactFrame, check_groups);
  static constexpr std::uint64_t kNormalGroups = offsetof(GpuContactFrame, normal_groups);

  /// Of the last submission.
  const GpuContactSummary& summary() const { return summary_.host()[0]; }

 private:
  DistanceGrid grid_;  ///< without its values
  ContactGroups groups_;
  bool forget_ = true;
  Eigen::Quaterniond clay_from_workspace_ = Eigen::Quaterniond::Identity();
  Kernel<ContactBeginArgs> begin_;
  Buffer<float> distances_;
  Buffer<GpuContactFrame> state_;
  Buffer<GpuContactSummary> summary_;
  Buffer<vec3> displacements_;
};

/// Finds contact on the GPU, and keeps what is known of each data point from frame to frame: the tool *push*.
class ContactFinder {
 public:
  /// As ContactFrame.
  ContactFinder(Gpu& gpu, const DistanceGrid& hand, std::uint32_t data_point_count,
                std::uint32_t project_groups = 0, std::uint32_t apply_groups = 0);

  /// The images of the hand (engine/sculpt/symmetry.h). When they change, the next frame starts anew. \pre
  /// nothing recorded before is still running
  void setMirrors(std::uint32_t mirrors);
  std::uint32_t mirrors() const { return mirrors_; }

  /// Starts a frame and checks it: element 0 of `fit` is the hand, `held` the clutch.
  void recordFrame(Recorder& recorder, const Buffer<GpuFit>& fit, bool held, const Buffer<vec3>& data_points);
  /// Records the displacements wanted, when the frame is not done.
  void recordPush(Recorder& recorder);
  /// The check after the data points have moved, when the frame is not done.
  void recordCheck(Recorder& recorder, const Buffer<vec3>& data_points);

  ContactFrame& shared() { return frame_; }
  const ContactFrame& shared() const { return frame_; }
  const Buffer<vec3>& displacements() const { return frame_.displacements(); }
  const GpuContactSummary& summary() const { return frame_.summary(); }
  GpuContactFrame frame() const { return frame_.state().download()[0]; }
  /// Those of image 0 first.
  std::vector<GpuContactPoint> points() const { return points_.download(); }
  void forget() { frame_.forget(); }

 private:
  void recordFind(Recorder& recorder, const Buffer<vec3>& data_points, bool first);

  Gpu& gpu_;
  ContactFrame frame_;
  std::uint32_t mirrors_ = 0;
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
/// workspace_from_hand, about the centre of gravity.
struct ContactPose {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Vec3 position = Vec3::Zero();
};
struct ContactMotion {
  ContactPose before, now;  ///< equal in a frame's repeats
  bool start = false;       ///< tracking begins: points inside are marked
  bool first = true;        ///< check of the frame
};
void contactReference(const DistanceGrid& hand, const ContactMotion& motion, const Vec3& data_point,
                      ContactPoint& point);
/// Where a reached point has to go, in the workspace.
Vec3 contactTarget(const ContactPose& now, const ContactPoint& point);

}  // namespace airclay
