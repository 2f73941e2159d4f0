// SPDX-License-Identifier: MIT
// Calibrated cameras around a workspace: what they are, and how a point becomes a pixel.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "engine/core/math.h"

namespace airclay {

/// OpenCV's two lens models (its calib3d manual): the rational radial and tangential one, and the fisheye
/// one.
enum class LensModel { kPerspective, kFisheye };

/// Intrinsics. Pixel centres stand at whole numbers.
struct Lens {
  LensModel model = LensModel::kPerspective;
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< pixels
  /// k1 k2 p1 p2 k3 k4 k5 k6 (perspective) or k1 k2 k3 k4 0 0 0 0 (fisheye).
  std::array<double, 8> distortion{};
  /// The end of the model's monotonic range: the distorted radius grows with the undistorted one up to here.
  /// Of r = |(x/z, y/z)| (perspective) or of the angle θ from the axis in radians (fisheye). May be infinite
  /// (perspective); at most π/2 (fisheye). Set by withMonotonicRange().
  double monotonic_limit = 0;
};

/// The lens with `monotonic_limit` computed from its coefficients.
Lens withMonotonicRange(Lens lens);

struct Camera {
  std::string name;           ///< also of its video or image folder
  int width = 0, height = 0;  ///< pixels
  Lens lens;
  Pose camera_from_world = Pose::Identity();
};

/// The cube that is watched.
struct Workspace {
  Vec3 center = Vec3::Zero();  ///< metres, world
  double edge_m = 0.6;         ///< the paper's 60 cm
};

struct Rig {
  std::vector<Camera> cameras;
  Workspace workspace;
};

/// Where a point in camera coordinates falls, distortion included, whether inside the image or not.
/// None when it lies behind the camera (z <= 0) or beyond the lens model's monotonic range.
std::optional<Vec2> projectThroughLens(const Lens& lens, const Vec3& point_in_camera);

/// Where the camera *sees* a point: as above, and inside the image: -1/2 <= u < width - 1/2, v alike.
std::optional<Vec2> project(const Camera& camera, const Vec3& point_in_world);

/// The unit direction, in camera coordinates, of the light that falls on a pixel: projectThroughLens' inverse
/// (Newton on the radius and the tangential terms). None where no direction in the monotonic range arrives
/// there.
std::optional<Vec3> rayThroughPixel(const Lens& lens, const Vec2& pixel);

/// Units that a rig file without [metadata] units is taken to be in.
enum class RigUnits { kAsWritten, kMetres, kMillimetres };

/// Reads Anipose's calibration TOML (Caliscope, FreeMoCap, Pose2Sim; `units` spelled out), in which any table
/// with a `matrix` is a camera, or Caliscope's camera_array.toml. \throw Error naming file, camera and key
/// when it is malformed or implausible, or says no size: rig_findings.h reads such a rig, too.
Rig readRig(const std::filesystem::path& file, RigUnits units = RigUnits::kAsWritten);

/// What a file says of one camera, before it is believed. Shared by every reader of rigs.
struct CameraEntry {
  std::string name;
  int width = 0, height = 0;       ///< pixels; 0 x 0: not said, the images do
  Mat3 matrix = Mat3::Identity();  ///< OpenCV's camera matrix
  /// 4, 5 or 8 values in OpenCV's order, or 12 or 14 of which the 9th and later are 0; 4 for the fisheye
  /// model.
  std::vector<double> distortions;
  bool fisheye = false;
  std::vector<double> rotation;  ///< camera_from_world: 3 values (Rodrigues) or 9 (a matrix, row by row)
  Vec3 translation_m = Vec3::Zero();
};

/// The camera that an entry describes; a matrix that is a rotation but for rounding (1e-3) is made one.
/// \throw Error naming `where` (the file), the camera and the key.
Camera cameraFromEntry(const CameraEntry& entry, const std::string& where);

/// More cameras than this in one rig is a mistaken file.
inline constexpr int kMaxCameras = 32;
/// Images are at least this wide and high, in pixels, and at most this: 0.8 GB an image.
inline constexpr int kMinImageSide = 16, kMaxImageSide = 16384;

/// How rotations are written: three numbers (Rodrigues), as every program reads them; or as matrices, which
/// readRig reads back to the last bit.
enum class WrittenRotations { kRodrigues, kMatrices };

/// Writes the rig as readRig reads it, in metres.
void writeRig(const std::filesystem::path& file, const Rig& rig,
              WrittenRotations rotations = WrittenRotations::kRodrigues);

/// \throw Error with the reason when the rig cannot be real: fewer than two cameras or more than kMaxCameras;
/// two of one name; NaN; a focal length or an image's size out of bounds; a rotation that is none; a camera
/// inside the cube; two cameras within edge/100 of each other; one farther than 1,000 edges; a camera that
/// sees nothing of the cube. `file` is named in the message.
void checkRig(const Rig& rig, const std::filesystem::path& file);

}  // namespace airclay
