// SPDX-License-Identifier: MIT
// What a recording says of a rig: which of its cameras were recorded, in which size, and what they saw.
#pragma once

#include "engine/hull/silhouette_agreement.h"

namespace airclay {

struct TakeInspectionOptions {
  int background_frames = 10;  ///< as TakeOptions'
  int instants = 4;            ///< how many frames' silhouettes are wanted
};

struct TakeInspection {
  std::vector<RigDiagnostic> findings;  ///< missing recordings, other sizes, masks that cannot be read
  SilhouetteSource trust = SilhouetteSource::kKnown;
  std::vector<MaskSet> instants;  ///< silhouettes in the rig's order, spread over the recording; none when
                                  ///< something is missing
};

/// Looks for the rig's cameras in a take's folder, gives those without a size that of their images, and
/// takes silhouettes: the folder's masks, else by segmentation (silhouette.h's reference, no device is
/// needed). \throw Error when there is no such folder.
TakeInspection inspectTake(const std::filesystem::path& folder, Rig& rig,
                           const TakeInspectionOptions& options = {});

}  // namespace airclay
