// SPDX-License-Identifier: MIT
// What is wrong with a rig, all of it: faults that no rig may have, and what looks like a mistake.
//
// readRig and checkRig (rig.h) stop at the first fault; here the list goes on.
#pragma once

#include "engine/camera/rig.h"
#include "engine/core/error.h"

namespace airclay {

enum class Severity {
  kFault,    ///< such a rig is refused
  kWarning,  ///< it may be meant, but is more often a mistake
};

struct RigDiagnostic {
  Severity severity = Severity::kFault;
  std::string camera;  ///< whose; empty: the whole rig's
  std::string what;    ///< what is wrong and what would be right, in one line
};

/// The finding as an Error says it: `FILE: camera "NAME": …`. `where`: the rig's file, or the folder of its
/// files, one of which the finding names itself then.
std::string faultMessage(const RigDiagnostic& finding, const std::string& where);

/// Its inverse.
RigDiagnostic faultFrom(const Error& error, const std::string& where);

/// A rig as it stands in its file: not checked, a camera whose size is not written is 0 x 0 (its images
/// say it), and one that cannot be read is left out and among the faults.
struct RigReading {
  std::string where;  ///< what messages name: the file, or the folder of several
  Rig rig;
  std::vector<RigDiagnostic> faults;  ///< in the file's order

  /// \throw Error with the first fault, if there is one.
  const Rig& rigWithoutFaults() const;
};

/// Reads what readRig reads. \throw Error when the file is no TOML or holds no camera.
RigReading readRigWithFaults(const std::filesystem::path& file, RigUnits units = RigUnits::kAsWritten);

/// All that checkRig refuses.
std::vector<RigDiagnostic> rigErrors(const Rig& rig);

/// Whether anything can be computed with it: a cube, sizes, focal lengths above 0, and finite numbers all.
bool canBeMeasured(const Rig& rig);

/// What looks like a mistake: units, axes and directions of poses, a size or a matrix of other images, a
/// lens that ends inside its image, cameras too far, too close together, or that see too little.
/// \pre canBeMeasured(rig)
std::vector<RigDiagnostic> rigWarnings(const Rig& rig);

/// A camera, measured against the workspace.
struct CameraFigures {
  std::string name;
  int width = 0, height = 0;  ///< pixels
  double view_deg = 0;        ///< the angle from the left border's middle to the right border's
  double distance_m = 0;      ///< from the cube's centre
  double pixels_per_mm = 0;   ///< at the cube's centre
  double seen_share = 0;      ///< of the cube, by this camera
};

struct RigFigures {
  std::vector<CameraFigures> cameras;
  double seen_by_two = 0;  ///< the share of the cube that two cameras or more see
};

/// \pre canBeMeasured(rig)
RigFigures measureRig(const Rig& rig);

/// The point nearest to all optical axes (least squares) and before the cameras; none where axes are
/// parallel.
std::optional<Vec3> whereAxesMeet(const Rig& rig);

/// What a file's poses may be instead of camera_from_world with OpenCV's axes.
enum class PoseReading {
  kWorldFromCamera,
  kGlCameraFromWorld,  ///< OpenGL's and Blender's cameras: y up, looking along -z
  kWorldFromGlCamera,
};

/// The rig as it is if its file's poses were that, with the words for it.
Rig reread(const Rig& rig, PoseReading poses);
std::string wordsOf(PoseReading poses);

inline constexpr PoseReading kPoseReadings[] = {
    PoseReading::kWorldFromCamera, PoseReading::kGlCameraFromWorld, PoseReading::kWorldFromGlCamera};

}  // namespace airclay
