// SPDX-License-Identifier: MIT
// Writes rigs in other programs' formats, as those programs write them; readRig or readOpenCvRig reads each
// back to the same rig.
#pragma once

#include <string_view>
#include <vector>

#include "engine/camera/rig.h"

namespace airclay {

enum class RigFormat {
  kAirclay,    ///< as writeRig
  kAnipose,    ///< calibration.toml of Anipose and FreeMoCap: every table except [metadata] is a camera
  kCaliscope,  ///< camera_array.toml
  kPose2Sim,   ///< Calib.toml
  kEasyMocap,  ///< a folder with intri.yml and extri.yml
};

/// The format named airclay, anipose, caliscope, pose2sim or easymocap; empty for any other name.
std::optional<RigFormat> rigFormatNamed(std::string_view name);

/// Writes the rig in metres; the workspace goes where the other program ignores it. `file` is an existing
/// folder for kEasyMocap. \throw Error if the format cannot express the rig (EasyMocap: a fisheye lens, or a
/// camera name that is not plain) or the file cannot be written.
void writeRigAs(RigFormat format, const std::filesystem::path& file, const Rig& rig);

/// What a user of the written file must know, one line per item: lenses that the program interprets
/// differently, names that its videos must have.
std::vector<std::string> rigFormatNotes(RigFormat format, const Rig& rig);

}  // namespace airclay
