// SPDX-License-Identifier: MIT
// Checks a recording against a rig: which cameras were recorded, their image sizes, and their silhouettes.
#pragma once

#include "engine/hull/silhouette_agreement.h"

namespace airclay {

struct TakeInspectionOptions {
  int background_frames = 10;  ///< as in TakeOptions
  int instants = 4;            ///< number of frames to extract silhouettes from
};

struct TakeInspection {
  std::vector<RigDiagnostic> findings;  ///< missing recordings, wrong sizes, unreadable masks
  SilhouetteSource source = SilhouetteSource::kKnown;
  /// Silhouettes in the rig's order, spread over the recording; empty if there are findings.
  std::vector<SilhouetteSet> instants;
};

/// Finds the rig's cameras in a take's folder, fills in missing image sizes, and extracts silhouettes: the
/// folder's masks, otherwise by segmentation (the CPU reference of silhouette.h; no device is needed). \throw
/// Error if there is no such folder.
TakeInspection inspectTake(const std::filesystem::path& folder, Rig& rig,
                           const TakeInspectionOptions& options = {});

}  // namespace airclay
