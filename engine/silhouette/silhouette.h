// SPDX-License-Identifier: MIT
// Silhouettes: which pixels show the hand.
//
// A background model a pixel (mean and spread, learned from the empty workspace), compared tolerantly of
// shadow and of small changes of brightness; the 3 x 3 majority against speckle; the largest connected part;
// small holes closed. Masks stay in the raw, distorted image: carving projects through the lens model, so
// nothing is resampled and no part of the field is lost.
#pragma once

#include "engine/camera/gpu_rig.h"
#include "engine/gpu/kernel.h"
#include "engine/gpu/recorder.h"
#include "shaders/silhouette/silhouette_io.h"

namespace airclay {

/// Cameras of the rig, in its order; all from the first on unless `count` says how many.
struct CameraRange {
  std::uint32_t first = 0, count = ~0u;
};

class Silhouettes {
 public:
  Silhouettes(Gpu& gpu, const GpuRig& rig);

  /// Records the learning of one frame of the empty workspace, at most kMaxLearnFrames; then finishLearning()
  /// makes the model. `images`: GpuRig's layout. Some cameras at a time, the first of them first: so that
  /// no submission takes long.
  void recordLearning(Recorder& recorder, const Buffer<std::uint32_t>& images,
                      const CameraRange& cameras = {});
  void finishLearning(Recorder& recorder, const CameraRange& cameras = {});
  bool learned() const { return learned_; }
  /// The next frame is the first to learn from.
  void forget() { learned_frames_ = 0, learned_ = false; }

  /// Records segmentation and cleaning of a frame. \pre learned()
  void record(Recorder& recorder, const Buffer<std::uint32_t>& images);

  /// One bit a pixel, GpuRig's layout. Also written by the host for masks that a take brings along.
  Buffer<std::uint32_t>& masks() { return masks_; }
  const Buffer<std::uint32_t>& masks() const { return masks_; }
  /// The background model, one word a pixel (silhouette_io.h), and the steps on the way: for comparison with
  /// the reference.
  const Buffer<std::uint32_t>& model() const { return model_; }
  const Buffer<std::uint32_t>& levels() const { return levels_; }
  const Buffer<std::uint32_t>& segmented() const { return segmented_; }
  const Buffer<std::uint32_t>& majorityMask() const { return majority_mask_; }
  const Buffer<std::uint32_t>& largestMask() const { return largest_mask_; }

 private:
  RunArgs runArgs(bool holes) const;
  BackgroundArgs backgroundArgs(const CameraRange& cameras) const;
  std::uint32_t countOf(const CameraRange& cameras) const;

  Gpu& gpu_;
  const GpuRig& rig_;
  Kernel<BackgroundArgs> add_, finish_;
  Kernel<SegmentArgs> segment_;
  Kernel<EdgeArgs> edges_;
  Kernel<MajorityArgs> majority_;
  Kernel<RunArgs> find_, join_, measure_, largest_kernel_, write_;
  Buffer<std::uint64_t> sums_;
  Buffer<std::uint32_t> model_;
  Buffer<std::uint32_t> levels_, segmented_, majority_mask_, largest_mask_, masks_;
  Buffer<std::uint32_t> run_counts_, runs_, labels_, areas_, largest_;
  std::uint32_t learned_frames_ = 0;
  bool learned_ = false;
};

/// Holes of up to this many pixels are closed: 100 in an image 640 wide, about 15 x 15 mm at a metre; the
/// ring of thumb and forefinger is larger.
std::uint32_t largestHole(int image_width);

// --- the reference, in double precision, step by step ---

/// A pixel's background: mean B, G, R and their common spread in grey levels.
struct BackgroundPixel {
  Vec3 mean = Vec3::Zero();
  double spread = 0;
};

/// From frames of tightly packed BGR bytes of one camera.
std::vector<BackgroundPixel> learnBackgroundReference(const std::vector<std::vector<std::uint8_t>>& frames);

/// How far a pixel differs from the background, in units of what may differ by chance (silhouette_io.h).
double scoreReference(const Vec3& seen, const BackgroundPixel& background);

/// The mask from an image's scores: at least 1, and not the smear of an edge (EdgeArgs in silhouette_io.h).
Mask edgesReference(int width, int height, const std::vector<double>& scores);

Mask majorityReference(const Mask& mask);
Mask largestPartReference(const Mask& mask);
Mask closeHolesReference(const Mask& mask, std::uint32_t largest_hole);

}  // namespace airclay
