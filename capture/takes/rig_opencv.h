// SPDX-License-Identifier: MIT
// Rigs in OpenCV's FileStorage form; and whichever form a rig's path turns out to have.
#pragma once

#include "engine/camera/rig_diagnostics.h"

namespace airclay {

/// Reads one of
///   EasyMocap's pair intri.yml (`names`, K_NAME, dist_NAME or D_NAME, H_NAME and W_NAME where given) and
///   extri.yml (Rot_NAME, or R_NAME by Rodrigues; T_NAME): metres unless `units` says millimetres;
///   OpenCV's stereo pair intrinsics.yml (M1, D1, M2, D2) and extrinsics.yml (R, T), or both in one file: the
///   cameras `left`, whose frame is the world, and `right`; T is in squares of the board or whatever its
///   user said, so `units` must say it.
/// `file`: either file of a pair. A camera whose size is not written is 0 x 0.
/// \throw Error naming file, camera and key when it is no such file.
ParsedRig readOpenCvRig(const std::filesystem::path& file, RigUnits units);

/// The rig of a file, by its ending: TOML, else OpenCV's YAML (or XML, or JSON); or that of a folder.
/// \throw Error as parseRig and readOpenCvRig, or when a folder has none.
ParsedRig readAnyRig(const std::filesystem::path& rig, RigUnits units);

/// The file of a take's folder that says its rig; none where there is none.
std::optional<std::filesystem::path> rigFileIn(const std::filesystem::path& folder);

}  // namespace airclay
