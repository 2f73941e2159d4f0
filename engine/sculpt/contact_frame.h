// SPDX-License-Identifier: MIT
// The state of a frame that all tools use on the GPU: the hand's last two poses, the progress of the repeats,
// and the displacements for the solver.
#pragma once

#include "engine/gpu/kernel.h"
#include "engine/gpu/recorder.h"
#include "engine/mesh/distance_grid.h"
#include "engine/sculpt/symmetry.h"
#include "shaders/sculpt/contact_io.h"

namespace airclay {

/// The hand's signed distances for the tools: 2.5 mm cells, 30 mm margin, relative to the hand's centre of
/// mass.
DistanceGrid contactGrid(const TriangleMesh& skin);

/// workspace_from_hand, with the origin of the hand frame moved to the centre of mass.
struct ContactPose {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Vec3 position = Vec3::Zero();
};

class ContactFrame {
 public:
  /// `hand`: a contactGrid(). `project_groups` and `apply_groups`: workgroup counts of the solver's two
  /// kernels in each repeat.
  ContactFrame(Gpu& gpu, const DistanceGrid& hand, std::uint32_t data_point_count,
               std::uint32_t project_groups = 0, std::uint32_t apply_groups = 0);

  /// The symmetry images of the hand (engine/sculpt/symmetry.h). A change implies forget().
  void setMirrors(std::uint32_t mirrors);
  std::uint32_t mirrors() const { return mirrors_; }
  /// The clay's rotation from the next frame on. Call forget() after a change.
  void setClayFromWorkspace(const Eigen::Quaterniond& clay_from_workspace) {
    clay_from_workspace_ = clay_from_workspace;
  }
  /// The next frame starts as if tracking had just begun.
  void forget() { forget_ = true; }

  /// Starts a frame: element 0 of `hands` is the pose of the sculpting hand, `held` the clutch. The check
  /// processes `images` symmetry images of each data point in separate workgroups.
  void recordBegin(Recorder& recorder, const Buffer<GpuHandPose>& hands, bool held, std::uint32_t images = 1);

  const Buffer<GpuContactFrame>& state() const { return state_; }
  /// One per data point, clay frame, metres; zero for points that the tool does not move.
  const Buffer<vec3>& displacements() const { return displacements_; }
  std::uint32_t dataPointCount() const { return static_cast<std::uint32_t>(displacements_.count()); }
  HandDistances hand() const;
  /// The arguments of a check that ends the repeats at `target_m`, or after `max_repeats`.
  ContactDecision decision(float target_m, std::uint32_t max_repeats,
                           std::uint32_t max_stalls = kContactMaxStalls) const;

  /// Workgroup counts of the kernels in a repeat; 0 once the frame is done.
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
