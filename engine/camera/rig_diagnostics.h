// SPDX-License-Identifier: MIT
// All errors and warnings of a rig.
//
// readRig and checkRig (rig.h) stop at the first error; these functions collect all of them.
#pragma once

#include <string_view>

#include "engine/camera/rig.h"
#include "engine/core/error.h"

namespace airclay {

enum class Severity {
  kError,    ///< the rig is rejected
  kWarning,  ///< probably a mistake, but possible
};

struct RigDiagnostic {
  Severity severity = Severity::kError;
  std::string camera;   ///< the camera's name; empty: concerns the whole rig
  std::string message;  ///< what is wrong and what is expected, in one line
};

/// The diagnostic as the message of an Error: `FILE: camera "NAME": …`. `where`: the rig's file, or the
/// folder of its files; in that case the diagnostic itself names the file.
std::string diagnosticMessage(const RigDiagnostic& diagnostic, const std::string& where);

/// The inverse of diagnosticMessage.
RigDiagnostic diagnosticFromError(const Error& error, const std::string& where);

/// A rig as parsed from its file, unchecked. A camera without a size is 0 x 0 (its images determine it); a
/// camera that cannot be parsed is omitted and listed in `errors`.
struct ParsedRig {
  std::string where;  ///< the file, or the folder of several, for messages
  Rig rig;
  std::vector<RigDiagnostic> errors;  ///< in file order

  /// \throw Error with the first of `errors`, if any.
  const Rig& validRig() const;
};

/// Reads the formats of readRig. \throw Error if the file is not TOML or contains no camera.
ParsedRig parseRig(const std::filesystem::path& file, RigUnits units = RigUnits::kAsWritten);

/// All errors that checkRig rejects a rig for.
std::vector<RigDiagnostic> rigErrors(const Rig& rig);

/// Whether metrics can be computed: a valid cube, image sizes and focal lengths, and finite values only.
bool isMeasurable(const Rig& rig);

/// Probable mistakes: units, pose conventions, a size or matrix that belongs to other images, a lens model
/// that ends inside the image, cameras that are too far away, too close together, or see too little of the
/// cube. \pre isMeasurable(rig)
std::vector<RigDiagnostic> rigWarnings(const Rig& rig);

/// One camera's geometry relative to the workspace.
struct CameraMetrics {
  std::string name;
  int width = 0, height = 0;  ///< pixels
  double view_deg = 0;        ///< horizontal field of view
  double distance_m = 0;      ///< to the cube's centre
  double pixels_per_mm = 0;   ///< at the cube's centre
  double seen_fraction = 0;   ///< of the cube's volume
};

struct RigMetrics {
  std::vector<CameraMetrics> cameras;
  double seen_by_two_fraction = 0;  ///< of the cube's volume, by at least two cameras
};

/// \pre isMeasurable(rig)
RigMetrics measureRig(const Rig& rig);

/// The point closest to all optical axes (least squares), world, metres. Empty if the axes are nearly
/// parallel or the point is behind a camera.
std::optional<Vec3> axesIntersection(const Rig& rig);

/// Conventions that a file may use instead of camera_from_world with OpenCV's axes.
enum class PoseConvention {
  kWorldFromCamera,
  kGlCameraFromWorld,  ///< OpenGL and Blender cameras: y up, looking along -z
  kWorldFromGlCamera,
};

/// The rig that results if the file's poses use this convention.
Rig withPoseConvention(const Rig& rig, PoseConvention poses);
/// A description for messages: "the poses are …".
std::string describe(PoseConvention poses);

/// Checks the number of a camera's distortion coefficients. \param place their key and line, for the message.
/// \throw Error also if thin prism or tilt coefficients are not 0, because Lens lacks them
void checkDistortions(const CameraEntry& entry, const std::string& place, const std::string& where);

/// The unit vector of x, y, z, -x, -y or -z; empty for any other name.
std::optional<Vec3> axisNamed(std::string_view name);

/// The rig in a world whose z axis is `up`, an axis of the old one; the workspace moves along.
Rig withUpAxis(const Rig& rig, const Vec3& up);

inline constexpr PoseConvention kPoseConventions[] = {
    PoseConvention::kWorldFromCamera, PoseConvention::kGlCameraFromWorld, PoseConvention::kWorldFromGlCamera};

}  // namespace airclay
