// SPDX-License-Identifier: MIT
// Reads rigs in OpenCV's FileStorage format, and rigs of any supported format.
#pragma once

#include "engine/camera/rig_diagnostics.h"

namespace airclay {

/// Reads one of these:
/// - EasyMocap's pair intri.yml (`names`, K_NAME, dist_NAME or D_NAME, optional H_NAME and W_NAME) and
/// extri.yml
///   (Rot_NAME, or R_NAME as Rodrigues; T_NAME), in metres unless `units` is millimetres;
/// - OpenCV's stereo pair intrinsics.yml (M1, D1, M2, D2) and extrinsics.yml (R, T), or both in one file:
/// cameras
///   `left`, whose frame is the world, and `right`. T may be in any unit, so `units` is required.
/// `file`: either file of a pair. A camera without a size is 0 x 0.
/// \throw Error naming file, camera and key if the file is neither.
ParsedRig readOpenCvRig(const std::filesystem::path& file, RigUnits units);

/// Reads a rig file by its extension, OpenCV's YAML, XML or JSON, otherwise TOML; or the rig in a folder.
/// \throw Error like parseRig and readOpenCvRig, or if the folder has no rig.
ParsedRig readAnyRig(const std::filesystem::path& rig, RigUnits units);

/// The rig file in a take's folder; empty if there is none.
std::optional<std::filesystem::path> rigFileIn(const std::filesystem::path& folder);

}  // namespace airclay
