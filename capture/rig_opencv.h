// SPDX-License-Identifier: MIT
// Rigs in OpenCV's FileStorage form: EasyMocap's pair intri.yml and extri.yml.
#pragma once

#include "engine/rig.h"

namespace airclay {

/// Reads FOLDER/intri.yml (`names`, K_NAME, dist_NAME, H_NAME and W_NAME where given) and FOLDER/extri.yml
/// (Rot_NAME, or R_NAME by Rodrigues; T_NAME). Metres, EasyMocap's unit, unless `units` says millimetres. A
/// camera without H_ and W_ has the size 0 x 0: the caller takes it from the pictures, then calls checkRig.
/// \throw Error naming file, camera and key.
Rig readOpenCvRig(const std::filesystem::path& folder, RigUnits units);

}  // namespace airclay
