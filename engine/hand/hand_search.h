// SPDX-License-Identifier: MIT
// The search for the hand from nothing, in a single frame: a coarse hull of what is probably the hand, poses
// at its ends, and their scores in the images (shaders/hand/search_io.h).
#pragma once

#include "engine/hand/outline.h"
#include "shaders/hand/search_io.h"

namespace airclay {

struct ScoredPose {
  GpuOutlinePose pose;
  int end = 0;       ///< of the part, in which the hand would be
  double score = 0;  ///< mean over the cameras that see the hand; lower is better
};

class HandSearch {
 public:
  HandSearch(Gpu& gpu, const GpuRig& rig, const OutlineModel& model);

  /// Poses to refine, at most `per_end` for each end of the arm, best first, all different; empty if nothing
  /// in the workspace could be a hand. \pre the evidence of the whole images is computed. Runs several
  /// submissions.
  std::vector<ScoredPose> candidates(Recorder& recorder, const Evidence& evidence,
                                     const GpuOutlineFrame& frame, double scale, std::size_t per_end,
                                     StageTimes& stage_ms);
  /// The scores of poses, in the same order. \pre candidates() of the same frame was called
  std::vector<double> scores(Recorder& recorder, const GpuOutlineFrame& frame,
                             std::span<const GpuOutlinePose> poses, StageTimes& stage_ms);

  // for comparison with the reference
  const Buffer<std::uint32_t>& blocks() const { return blocks_; }
  const Buffer<std::uint32_t>& hull() const { return hull_; }
  const Buffer<float>& cameraScores() const { return scores_; }
  const Buffer<GpuOutlinePose>& poses() const { return poses_; }

 private:
  std::vector<int> largestPart() const;
  std::vector<ScoredPose> hypotheses(const std::vector<int>& part, double scale) const;

  const GpuRig& rig_;
  const OutlineModel& model_;
  std::size_t least_voxels_;
  Kernel<SearchShrinkArgs> shrink_;
  Kernel<SearchHullArgs> hull_kernel_;
  Kernel<SearchScoreArgs> score_;
  Buffer<std::uint32_t> blocks_, hull_;
  Buffer<vec3> points_;
  Buffer<GpuOutlineFrame> frame_;
  Buffer<GpuOutlinePose> poses_;
  Buffer<float> scores_;
};

// --- the reference implementation, in double precision ---

/// The mean probability of the hand in the block (x, y) of 4 x 4 pixels, 0 to 1. `evidence`: a camera's
/// cells.
double blockReference(std::span<const std::uint8_t> evidence, std::uint32_t tile_columns, int x, int y);
/// The mean log-probability of the hand at a point (workspace frame) over the cameras with `bits` set; empty
/// unless two see it. `blocks`: HandSearch::blocks().
std::optional<double> hullReference(const GpuRig& rig, std::span<const std::uint32_t> blocks,
                                    std::uint32_t bits, const Vec3& point);
/// The score of a pose in a camera; -1 where the camera sees too little.
double scoreReference(const GpuRig& rig, std::size_t camera, const OutlineModel& model,
                      const GpuOutlineFrame& frame, const GpuOutlinePose& pose,
                      std::span<const std::uint32_t> blocks);

}  // namespace airclay
