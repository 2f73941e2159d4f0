// SPDX-License-Identifier: MIT
// Whether silhouettes and a rig belong together. The visual hull of consistent silhouettes projects back onto
// all of them (Laurentini 1994); with a wrong rig the views exclude each other, and little or nothing is
// left.
#pragma once

#include <span>

#include "engine/camera/gpu_rig.h"
#include "engine/camera/rig_diagnostics.h"

namespace airclay {

/// A camera's silhouettes against the hull of all, in pixels; of large ones, every n-th pixel counts.
struct SilhouetteAgreement {
  std::size_t pixels = 0;     ///< of the silhouettes
  std::size_t in_cube = 0;    ///< of those, the ones whose ray crosses the cube
  std::size_t explained = 0;  ///< of those, the ones whose ray meets the hull, or passes within a voxel of it

  double explainedShare() const {
    return in_cube ? static_cast<double>(explained) / static_cast<double>(in_cube) : 0;
  }
};

/// Masks of one instant, a camera each.
using MaskSet = std::vector<Mask>;

/// A camera each, all instants together. \pre the rig has no fault, the masks have its sizes
std::vector<SilhouetteAgreement> silhouetteAgreement(const Rig& rig, std::span<const MaskSet> instants);

/// Where silhouettes are from: masks or a known background; or the first frames were taken to be empty.
enum class SilhouetteSource { kKnown, kAssumed };

/// What the agreement says of the rig: silhouettes beside the cube; a rig that contradicts them, and if that
/// is found, which camera, which two exchanged ones or which other reading of units, axes and poses it is due
/// to. Fewer than 3 of 10 pixels explained are a fault, where the silhouettes are to be trusted.
std::vector<RigDiagnostic> silhouetteDiagnostics(const Rig& rig, std::span<const MaskSet> instants,
                                                 std::span<const SilhouetteAgreement> agreement,
                                                 SilhouetteSource trust = SilhouetteSource::kKnown);

}  // namespace airclay
