// SPDX-License-Identifier: MIT
#include "engine/silhouette/silhouette.h"

#include <algorithm>

#include "engine/core/error.h"
#include "shaders/silhouette/background_add.comp.h"
#include "shaders/silhouette/background_finish.comp.h"
#include "shaders/silhouette/edges.comp.h"
#include "shaders/silhouette/majority.comp.h"
#include "shaders/silhouette/runs_find.comp.h"
#include "shaders/silhouette/runs_join.comp.h"
#include "shaders/silhouette/runs_largest.comp.h"
#include "shaders/silhouette/runs_measure.comp.h"
#include "shaders/silhouette/runs_write.comp.h"
#include "shaders/silhouette/segment.comp.h"

namespace airclay {
namespace {

std::vector<std::uint32_t> constants(const GpuRig& rig) {
  const auto [width, height] = rig.sameSize();
  return {kSilhouetteWorkgroup, width, height};
}

}  // namespace

std::uint32_t largestHole(int image_width) {
  return std::max<std::uint32_t>(4,
                                 static_cast<std::uint32_t>(100LL * image_width * image_width / (640 * 640)));
}

Silhouettes::Silhouettes(Gpu& gpu, const GpuRig& rig)
    : gpu_(gpu),
      rig_(rig),
      add_(gpu, "background_add", background_add_comp, constants(rig)),
      finish_(gpu, "background_finish", background_finish_comp, constants(rig)),
      segment_(gpu, "segment", segment_comp, constants(rig)),
      edges_(gpu, "edges", edges_comp, constants(rig)),
      majority_(gpu, "majority", majority_comp, constants(rig)),
      find_(gpu, "runs_find", runs_find_comp, constants(rig)),
      join_(gpu, "runs_join", runs_join_comp, constants(rig)),
      measure_(gpu, "runs_measure", runs_measure_comp, constants(rig)),
      largest_kernel_(gpu, "runs_largest", runs_largest_comp, constants(rig)),
      write_(gpu, "runs_write", runs_write_comp, constants(rig)),
      levels_(gpu, std::size_t(kScoreLevels) * rig.maskWords()),
      segmented_(gpu, rig.maskWords()),
      majority_mask_(gpu, rig.maskWords()),
      largest_mask_(gpu, rig.maskWords()),
      masks_(gpu, rig.maskWords(), Memory::kHost),
      largest_(gpu, rig.cameraCount()) {
  const std::size_t rows = std::size_t(rig.cameraCount()) * rig.maxRows();
  run_counts_ = Buffer<std::uint32_t>(gpu, rows);
  runs_ = Buffer<std::uint32_t>(gpu, rows * kMaxRuns);
  labels_ = Buffer<std::uint32_t>(gpu, rows * kMaxRuns);
  areas_ = Buffer<std::uint32_t>(gpu, rows * kMaxRuns);
}

void Silhouettes::recordLearning(Recorder& recorder, const Buffer<std::uint32_t>& images,
                                 const CameraRange& cameras) {
  if (cameras.first == 0) {
    if (learned_frames_ == kMaxLearnFrames)
      throw Error("too many frames of the empty workspace; expected at most " +
                  std::to_string(kMaxLearnFrames));
    if (learned_frames_ == 0) {
      sums_ = Buffer<std::uint64_t>(gpu_, std::size_t(kLearnSums) * rig_.pixels());
      model_ = Buffer<std::uint32_t>(gpu_, rig_.pixels());
      recorder.fill(sums_.raw(), 0);
    }
    ++learned_frames_;
  }
  BackgroundArgs args = backgroundArgs(cameras);
  args.images = images;
  recorder.dispatch(add_, args, groupsFor(rig_.maxPixels(), kSilhouetteWorkgroup), countOf(cameras));
}

void Silhouettes::finishLearning(Recorder& recorder, const CameraRange& cameras) {
  if (learned_frames_ == 0)
    throw Error("the background cannot be learned without a frame of the empty workspace");
  BackgroundArgs args = backgroundArgs(cameras);
  args.model = model_;
  recorder.dispatch(finish_, args, groupsFor(rig_.maxPixels(), kSilhouetteWorkgroup), countOf(cameras));
  learned_ = true;
}

std::uint32_t Silhouettes::countOf(const CameraRange& cameras) const {
  return std::min(cameras.count, rig_.cameraCount() - cameras.first);
}

BackgroundArgs Silhouettes::backgroundArgs(const CameraRange& cameras) const {
  BackgroundArgs args{};
  args.cameras = rig_.cameras();
  args.sums = sums_;
  args.frames = learned_frames_;
  args.first_camera = cameras.first;
  return args;
}

RunArgs Silhouettes::runArgs(bool holes) const {
  RunArgs args{};
  args.cameras = rig_.cameras();
  args.masks.address =
      (holes ? largest_mask_ : majority_mask_).raw().address();  // read as pairs of words, here and below
  args.run_counts = run_counts_;
  args.runs = runs_;
  args.labels = labels_;
  args.areas = areas_;
  args.largest = largest_;
  args.result.address = (holes ? masks_ : largest_mask_).raw().address();
  args.max_rows = rig_.maxRows();
  args.holes = holes;
  args.largest_hole = largestHole(rig_.rig().cameras.front().width);
  return args;
}

void Silhouettes::record(Recorder& recorder, const Buffer<std::uint32_t>& images) {
  const std::uint32_t cameras = rig_.cameraCount();
  const std::uint32_t pair_groups = groupsFor(rig_.maxRowWords() / 2 * rig_.maxRows(), kSilhouetteWorkgroup);
  const std::uint32_t row_groups = groupsFor(rig_.maxRows(), kSilhouetteWorkgroup);

  SegmentArgs segment{};
  segment.cameras = rig_.cameras();
  segment.images = images;
  segment.model = model_;
  segment.levels.address = levels_.raw().address();
  recorder.dispatch(segment_, segment, pair_groups, cameras);

  EdgeArgs edges{};
  edges.cameras = rig_.cameras();
  edges.levels.address = levels_.raw().address();
  edges.masks.address = segmented_.raw().address();
  recorder.dispatch(edges_, edges, pair_groups, cameras);

  MajorityArgs majority{};
  majority.cameras = rig_.cameras();
  majority.masks.address = segmented_.raw().address();
  majority.cleaned.address = majority_mask_.raw().address();
  recorder.dispatch(majority_, majority, pair_groups, cameras);

  for (const bool holes : {false, true}) {
    const RunArgs args = runArgs(holes);
    recorder.dispatch(find_, args, row_groups, cameras);
    recorder.dispatch(join_, args, row_groups, cameras);
    recorder.dispatch(measure_, args, row_groups, cameras);
    if (!holes) recorder.dispatch(largest_kernel_, args, 1, cameras);
    recorder.dispatch(write_, args, row_groups, cameras);
  }
}

}  // namespace airclay
