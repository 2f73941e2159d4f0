// SPDX-License-Identifier: MIT
// Checks whether silhouettes and a rig belong together. The visual hull of consistent silhouettes projects
// back onto all of them (Laurentini 1994); with a wrong rig the views contradict each other, and the hull is
// small or empty.
#pragma once

#include <span>

#include "engine/camera/gpu_rig.h"
#include "engine/camera/rig_diagnostics.h"

namespace airclay {

/// One camera's silhouettes compared with the hull, in pixels; large silhouettes are subsampled.
struct SilhouetteAgreement {
  std::size_t pixels = 0;     ///< of the silhouettes
  std::size_t in_cube = 0;    ///< those of them whose ray crosses the cube
  std::size_t explained = 0;  ///< those of in_cube whose ray hits the hull or passes within a voxel of it

  double explainedFraction() const {
    return in_cube ? static_cast<double>(explained) / static_cast<double>(in_cube) : 0;
  }
};

/// Masks of one instant, one per camera.
using SilhouetteSet = std::vector<Silhouette>;

/// One entry per camera, summed over all instants. \pre the rig has no errors and the masks have its sizes
std::vector<SilhouetteAgreement> silhouetteAgreement(const Rig& rig, std::span<const SilhouetteSet> instants);

/// The origin of silhouettes: masks or a known background; or a background that assumes empty first frames.
enum class SilhouetteSource { kKnown, kAssumed };

/// Diagnoses silhouettes outside the cube and rigs that contradict the silhouettes, with the cause if it is
/// found: one camera, two swapped cameras, or another convention of units, axes or poses. If less than 30 %
/// of the pixels are explained, the diagnostic is an error, provided that the silhouettes are kKnown.
std::vector<RigDiagnostic> silhouetteDiagnostics(const Rig& rig, std::span<const SilhouetteSet> instants,
                                                 std::span<const SilhouetteAgreement> agreement,
                                                 SilhouetteSource source = SilhouetteSource::kKnown);

}  // namespace airclay
