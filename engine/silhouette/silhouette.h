// SPDX-License-Identifier: MIT
// Silhouettes: the pixels that show the hand.
//
// Compares each pixel with its background model (mean and spread, learned from the empty workspace),
// tolerating shadows and small changes of brightness; removes speckle by a 3 x 3 majority; keeps the largest
// connected part; closes small holes. Masks are in the raw, distorted image: carving projects through the
// lens model, so nothing is resampled and the whole field of view is used.
#pragma once

#include "engine/camera/gpu_rig.h"
#include "engine/gpu/kernel.h"
#include "engine/gpu/recorder.h"
#include "shaders/silhouette/silhouette_io.h"

namespace airclay {

/// A range of the rig's cameras; by default all.
struct CameraRange {
  std::uint32_t first = 0, count = ~0u;
};

class Silhouettes {
 public:
  Silhouettes(Gpu& gpu, const GpuRig& rig);

  /// Records learning from one frame of the empty workspace, at most kMaxLearnFrames; finishLearning() then
  /// computes the model. `images`: GpuRig's layout. To keep submissions short, call both for a few cameras at
  /// a time, starting with camera 0.
  void recordLearning(Recorder& recorder, const Buffer<std::uint32_t>& images,
                      const CameraRange& cameras = {});
  void finishLearning(Recorder& recorder, const CameraRange& cameras = {});
  bool learned() const { return learned_; }
  /// Discards the model; learning starts over with the next frame.
  void forget() { learned_frames_ = 0, learned_ = false; }

  /// Records segmentation and clean-up of a frame. \pre learned()
  void record(Recorder& recorder, const Buffer<std::uint32_t>& images);

  /// One bit per pixel, GpuRig's layout. The host writes it for takes that contain masks.
  Buffer<std::uint32_t>& masks() { return masks_; }
  const Buffer<std::uint32_t>& masks() const { return masks_; }
  /// The background model, one word per pixel (silhouette_io.h), and intermediate results, for comparison
  /// with the reference.
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

/// The largest hole that is closed, in pixels: 100 in an image 640 pixels wide, about 15 x 15 mm at a
/// distance of one metre. The ring formed by thumb and index finger is larger.
std::uint32_t largestHole(int image_width);

// --- the reference implementation, in double precision, step by step ---

/// A pixel's background: mean B, G, R and their common standard deviation, in grey levels.
struct BackgroundPixel {
  Vec3 mean = Vec3::Zero();
  double spread = 0;
};

/// Learns the model of one camera from frames of BGR bytes without padding.
std::vector<BackgroundPixel> learnBackgroundReference(const std::vector<std::vector<std::uint8_t>>& frames);

/// A pixel's difference from the background, relative to the tolerance (silhouette_io.h).
double scoreReference(const Vec3& seen, const BackgroundPixel& background);

/// The mask from an image's scores: pixels of at least 1 that are not edge blur (EdgeArgs in
/// silhouette_io.h).
Silhouette edgesReference(int width, int height, const std::vector<double>& scores);

Silhouette majorityReference(const Silhouette& mask);
Silhouette largestPartReference(const Silhouette& mask);
Silhouette closeHolesReference(const Silhouette& mask, std::uint32_t largest_hole);

}  // namespace airclay
