// SPDX-License-Identifier: MIT
// What all tools share of a frame on the GPU: the hand's two poses, the progress of the repeats, and the
// displacements for the solver.
#pragma once

#include "engine/gpu/kernel.h"
#include "engine/gpu/recorder.h"
#include "engine/mesh/distance_grid.h"
#include "engine/sculpt/symmetry.h"
#include "shaders/sculpt/contact_io.h"

namespace airclay {

/// The hand's signed distances for the tools: 2.5 mm cells, 30 mm margin, relative to the solid's center of
/// mass.
DistanceGrid contactGrid(const TriangleMesh& skin);

/// workspace_from_hand, of the center of mass.
struct ContactPose {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Vec3 position = Vec3::Zero();
};

class ContactFrame {
 public:
  /// `hand`: relative to the center of mass, axes of the hand's frame. `project_groups` and `apply_groups`:
  /// workgroups of the solver's two kernels that each repeat dispatches.
  ContactFrame(Gpu& gpu, const DistanceGrid& hand, std::uint32_t data_point_count,
               std::uint32_t project_groups = 0, std::uint32_t apply_groups = 0);

  /// The symmetry images of the hand (engine/sculpt/symmetry.h). A change starts over, see forget().
  void setMirrors(std::uint32_t mirrors);
  std::uint32_t mirrors() const { return mirrors_; }
  /// The clay's rotation, from the next frame on. After a change call forget().
  void setClayFromWorkspace(const Eigen::Quaterniond& clay_from_workspace) {
    clay_from_workspace_ = clay_from_workspace;
  }
  /// The next frame starts over, as if tracking began.
  void forget() { forget_ = true; }

  /// Starts a frame: element 0 of `hands` is the pose of the hand that sculpts, `held` the clutch. The check
  /// looks at `images` of each data point in workgroups of their own.
  void recordBegin(Recorder& recorder, const Buffer<GpuHandPose>& hands, bool held, std::uint32_t images = 1);

  const Buffer<GpuContactFrame>& state() const { return state_; }
  /// One per data point, in the clay's frame, metres; zero for points that the tool leaves alone.
  const Buffer<vec3>& displacements() const { return displacements_; }
  std::uint32_t dataPointCount() const { return static_cast<std::uint32_t>(displacements_.count()); }
  HandDistances hand() const;
  /// For a check that ends the repeats at `target_m`, or after `max_repeats`.
  ContactDecision decision(float target_m, std::uint32_t max_repeats,
                           std::uint32_t max_stalls = kContactMaxStalls) const;

  /// Workgroups of the kernels that a repeat dispatches; 0 once the frame is done.
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
  std::uint32_t mirrors_ = 0;
  bool forget_ = true;
  Eigen::Quaterniond clay_from_workspace_ = Eigen::Quaterniond::Identity();
  Kernel<ContactBeginArgs> begin_;
  Buffer<float> distances_;
  Buffer<GpuContactFrame> state_;
  Buffer<GpuContactSummary> summary_;
  Buffer<vec3> displacements_;
};

}  // namespace airclay
