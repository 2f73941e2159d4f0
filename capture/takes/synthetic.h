// SPDX-License-Identifier: MIT
// A recording that no camera made: the scripted hand before synthetic cameras (engine/synthetic/sensor.h),
// with its truth. What `airclay demo` tracks, pixel by pixel like any take.
#pragma once

#include <memory>

#include "capture/takes/recording.h"
#include "engine/gpu/gpu.h"
#include "engine/synthetic/demo_scene.h"

namespace airclay {

struct SyntheticOptions {
  Rig rig = demoRig();
  HandScript script = demoScript();
  std::vector<TriangleMesh> meshes = demoArm();  ///< hand frame
  double rate_hz = kDemoRateHz;
  std::uint32_t seed = 1;
  double noise_sigma = 2.5;  ///< of 255
  double drift = 0.02;       ///< share by which the brightness swings slowly, as a camera's own exposure does
};

/// The same options give the same bytes, in whatever order frames are read.
class Synthetic : public Recording {
 public:
  explicit Synthetic(Gpu& gpu, const SyntheticOptions& options = {});
  ~Synthetic() override;

  const Rig& rig() const override;
  int frameCount() const override;
  double rateHz() const override;
  double timeOf(int frame) const override;
  int backgroundFrames() const override;  ///< those before the hand appears
  bool readImages(int frame, Buffers bgr) override;
  /// Of every frame with the hand in it.
  const std::optional<std::vector<TimedPose>>& truth() const override;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace airclay
