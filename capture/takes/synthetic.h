// SPDX-License-Identifier: MIT
// The scripted hand, recorded by synthetic cameras (engine/synthetic/sensor.h), with true poses. `airclay
// demo` tracks it like any take.
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
  double noise_sigma = 2.5;  ///< standard deviation on a scale of 255
  double drift = 0.02;       ///< relative amplitude of the slow brightness changes of automatic exposure
};

/// Equal options give identical bytes, in whatever order frames are read.
class Synthetic : public Recording {
 public:
  explicit Synthetic(Gpu& gpu, const SyntheticOptions& options = {});
  ~Synthetic() override;

  const Rig& rig() const override;
  int frameCount() const override;
  double rateHz() const override;
  double timeOf(int frame) const override;
  int backgroundFrames() const override;  ///< frames before the hand appears
  bool readImages(int frame, Buffers bgr) override;
  /// The pose in every frame that shows the hand.
  const std::optional<std::vector<TimedPose>>& truth() const override;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace airclay
