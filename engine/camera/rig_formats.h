// SPDX-License-Identifier: MIT
// Rigs for other programs: each file as that program writes it itself, and read by readRig or readOpenCvRig
// to the same rig.
#pragma once

#include <string_view>
#include <vector>

#include "engine/camera/rig.h"

namespace airclay {

enum class RigFormat {
  kAirclay,    ///< writeRig's
  kAnipose,    ///< calibration.toml of Anipose, also FreeMoCap's: every table but [metadata] is a camera
  kCaliscope,  ///< camera_array.toml
  kPose2Sim,   ///< Calib.toml
  kEasyMocap,  ///< a folder with intri.yml and extri.yml
};

/// The form of this name: airclay, anipose, caliscope, pose2sim, easymocap. None of any other.
std::optional<RigFormat> rigFormatNamed(std::string_view name);

/// Writes the rig, metres; the workspace, which none of the others knows, where the program does not look.
/// \throw Error when the program's form cannot say the rig: a fisheye lens or such a camera's name for
/// EasyMocap; or when `file`, for EasyMocap an existing folder, cannot be written.
void writeRigAs(RigFormat form, const std::filesystem::path& file, const Rig& rig);

/// What the user of the written file must know, a line each: lenses that the program takes for others, names
/// that its videos must have.
std::vector<std::string> rigFormatNotes(RigFormat form, const Rig& rig);

}  // namespace airclay
