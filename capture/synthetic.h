// SPDX-License-Identifier: MIT
// A recording that no camera made: the scripted hand before synthetic cameras (engine/sensor.h), with its
// truth. What `airclay demo` tracks, pixel by pixel like any take.
#pragma once

#include <memory>

#include "capture/recording.h"
#include "engine/gpu/gpu.h"
#include "engine/mesh.h"
#include "engine/script.h"

namespace airclay {

/// Four cameras of 640 x 480 about 1.1 m from the 60 cm cube, at different heights and all round it, every
/// one seeing all of the cube, with the mild lens distortion of webcams.
Rig demoRig();

/// The built-in right hand and its forearm, as the cameras see them.
std::vector<TriangleMesh> demoArm();

struct SyntheticOptions {
  Rig rig = demoRig();
  HandScript script = demoScript();
  std::vector<TriangleMesh> meshes = demoArm();  ///< hand frame
  double rate_hz = 30;
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
  bool readPictures(int frame, Buffers bgr) override;
  /// Of every frame with the hand in it.
  const std::optional<std::vector<TimedPose>>& truth() const override;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace airclay
