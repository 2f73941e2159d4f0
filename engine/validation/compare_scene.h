// SPDX-License-Identifier: MIT
// What the parts of `airclay compare` share: the list of results, and the demo's scene.
#pragma once

#include <cmath>

#include "engine/hand/hand_search.h"
#include "engine/hull/carve.h"
#include "engine/synthetic/demo_scene.h"
#include "engine/validation/compare.h"

namespace airclay {

inline constexpr int kPressingFrame = 54;  ///< the hand is against the clay's side
inline constexpr int kComparedVoxels = 128;

class Comparisons {
 public:
  explicit Comparisons(std::string device) : device_(std::move(device)) {}
  void add(const std::string& name, double error, double tolerance) {
    list_.push_back({name, device_, error, tolerance, error <= tolerance});  // NaN does not pass
  }
  std::vector<KernelComparison> take() { return std::move(list_); }

 private:
  std::string device_;
  std::vector<KernelComparison> list_;
};

/// The maximum; NaN if either is NaN, so that it does not pass.
inline double maxOrNan(double a, double b) {
  return a >= b || std::isnan(a) ? a : b;
}

/// The difference between a stored and an exact value, beyond rounding to a whole step.
inline double beyondRounding(double stored, double exact, double step) {
  return std::max(0.0, std::abs(stored - exact) - 0.5 * step);
}

/// The demo's scene up to the masks of one frame.
struct CompareScene {
  explicit CompareScene(Gpu& device)
      : gpu(device),
        gpu_rig(gpu, rig),
        cameras(gpu, gpu_rig),
        silhouettes(gpu, gpu_rig),
        carver(gpu, gpu_rig, kComparedVoxels),
        recorder(gpu) {}

  std::vector<std::uint8_t> image(std::span<const std::uint32_t> images, std::size_t camera) const {
    const GpuCamera& c = gpu_rig.camera(camera);
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(images.data() + c.image_words);
    return {bytes, bytes + std::size_t(3) * c.width * c.height};
  }

  Gpu& gpu;
  Rig rig = demoRig();
  GpuRig gpu_rig;
  DemoCameras cameras;
  Silhouettes silhouettes;
  Carver carver;
  Recorder recorder;
  std::vector<Silhouette> masks;  ///< of kPressingFrame
};

/// The stages of the robust fit, near the true pose of kPressingFrame.
struct OutlineScene {
  explicit OutlineScene(CompareScene& s);
  /// A camera's part of a buffer with `per_cell` values in each cell.
  template <class T>
  std::span<const T> cells(const std::vector<T>& all, std::size_t camera) const {
    return std::span(all).subspan(firstCell(scene.gpu_rig.camera(camera)));
  }
  /// The evidence bytes of a camera's cells.
  std::span<const std::uint8_t> evidenceBytes(const std::vector<std::uint32_t>& words,
                                              std::size_t camera) const;
  /// Records the fit from `start` in a submission of its own.
  void fit(const GpuOutlinePose& start, const OutlineStage& stage, const ScalePrior& scale);

  CompareScene& scene;
  const Buffer<std::uint32_t>& images;  ///< of kPressingFrame
  const Buffer<std::uint32_t>& model;
  Evidence evidence;
  OutlineFitter fitter;
  HandSearch search;
  GpuOutlineFrame frame;  ///< with a motion and camera times
  GpuOutlinePose truth;
};

/// The kernels of the evidence. Leaves the evidence of the whole images, with learned colours.
void compareEvidence(OutlineScene& scene, Comparisons& comparisons);
/// All kernels of the robust fit. \pre the background is learned
void compareOutline(CompareScene& scene, Comparisons& comparisons);

}  // namespace airclay
