// SPDX-License-Identifier: MIT
// Calibrated cameras around a workspace, and the projection of points to pixels.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "engine/core/math.h"

namespace airclay {

/// OpenCV's two lens models (see its calib3d manual): rational radial and tangential distortion, and fisheye.
enum class LensModel { kPerspective, kFisheye };

/// Intrinsics. Pixel centres are at whole numbers.
struct Lens {
  LensModel model = LensModel::kPerspective;
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< pixels
  /// k1 k2 p1 p2 k3 k4 k5 k6 (perspective) or k1 k2 k3 k4 0 0 0 0 (fisheye).
  std::array<double, 8> distortion{};
  /// The end of the model's monotonic range, up to which the distorted radius grows with the undistorted one:
  /// r = |(x/z, y/z)|, possibly infinite (perspective), or the angle θ from the axis in radians, at most π/2
  /// (fisheye). Set by withMonotonicRange().
  double monotonic_limit = 0;
};

/// The lens with `monotonic_limit` computed from its coefficients.
Lens withMonotonicRange(Lens lens);

struct Camera {
  std::string name;           ///< also the name of its video or image folder
  int width = 0, height = 0;  ///< pixels
  Lens lens;
  Pose camera_from_world = Pose::Identity();
};

/// The cube that the cameras observe; its axes are the world's.
struct Workspace {
  Vec3 center = Vec3::Zero();  ///< metres, world
  double edge_m = 0.6;         ///< 60 cm, as in the paper
};

struct Rig {
  std::vector<Camera> cameras;
  Workspace workspace;
};

/// The pixel coordinates of a point in the camera frame, with distortion, inside the image or not.
/// Empty if the point is behind the camera (z <= 0) or beyond the lens model's monotonic range.
std::optional<Vec2> projectThroughLens(const Lens& lens, const Vec3& point_in_camera);

/// The same for a point in the world frame; empty also outside the image: -1/2 <= u < width - 1/2, likewise
/// v.
std::optional<Vec2> project(const Camera& camera, const Vec3& point_in_world);

/// The unit direction, in the camera frame, of the ray through a pixel: the inverse of projectThroughLens
/// (Newton iterations on the radius and the tangential terms). Empty if no direction in the monotonic range
/// projects there.
std::optional<Vec3> rayThroughPixel(const Lens& lens, const Vec2& pixel);

/// Units of a rig file whose [metadata] does not state any; kAsWritten: missing units are an error.
enum class RigUnits { kAsWritten, kMetres, kMillimetres };

/// Reads Anipose's calibration TOML (also Caliscope, FreeMoCap, Pose2Sim), in which every table with a
/// `matrix` is a camera, or Caliscope's camera_array.toml. \throw Error naming file, camera and key if the
/// rig is malformed, implausible, or lacks an image size; parseRig (rig_diagnostics.h) reads such rigs too.
Rig readRig(const std::filesystem::path& file, RigUnits units = RigUnits::kAsWritten);

/// One camera as read from a file, unchecked. Common to all rig readers.
struct CameraEntry {
  std::string name;
  int width = 0, height = 0;       ///< pixels; 0 x 0: not in the file, taken from the images
  Mat3 matrix = Mat3::Identity();  ///< OpenCV's camera matrix
  /// 4, 5 or 8 values in OpenCV's order, or 12 or 14 whose 9th and later are 0; 4 for the fisheye model.
  std::vector<double> distortions;
  bool fisheye = false;
  std::vector<double> rotation;  ///< camera_from_world: 3 values (Rodrigues) or 9 (a matrix, row by row)
  Vec3 translation_m = Vec3::Zero();
};

/// Converts an entry to a camera. A rotation matrix may be off by rounding (1e-3) and is orthonormalized.
/// \throw Error naming `where` (the file), the camera and the key.
Camera cameraFromEntry(const CameraEntry& entry, const std::string& where);

/// The most cameras in a rig.
inline constexpr int kMaxCameras = 32;
/// Bounds of an image's width and height, pixels; the largest image takes 0.8 GB.
inline constexpr int kMinImageSide = 16, kMaxImageSide = 16384;

/// How rotations are written: as rotation vectors (Rodrigues), which every program reads, or as matrices,
/// which readRig restores bit for bit.
enum class RotationFormat { kRodrigues, kMatrices };

/// Writes a rig that readRig reads, in metres. \throw Error if the file cannot be written.
void writeRig(const std::filesystem::path& file, const Rig& rig,
              RotationFormat rotations = RotationFormat::kRodrigues);

/// \throw Error, naming `file`, if the rig is physically impossible: fewer than two or more than kMaxCameras
/// cameras; duplicate names; values that are not finite; a focal length or image size out of bounds; an
/// invalid rotation; a camera inside the cube, within edge/100 of another, farther than 1,000 edges from the
/// cube, or that sees nothing of it.
void checkRig(const Rig& rig, const std::filesystem::path& file);

}  // namespace airclay
