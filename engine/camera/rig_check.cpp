// SPDX-License-Identifier: MIT
// Checks that a rig is physically possible, so that a mistyped or mixed-up calibration is found before any
// image is decoded.
#include <algorithm>
#include <cmath>
#include <sstream>

#include "engine/camera/camera_name.h"
#include "engine/camera/rig_diagnostics.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

// Tolerance of RᵀR against I, for rotations printed with few digits.
constexpr double kRotationTolerance = 1e-3;
// Below this, the matrix was written in double precision and is kept bit for bit.
constexpr double kExactRotation = 1e-14;

std::string cameraIn(const std::string& where, const std::string& name) {
  return where + ": camera \"" + name + "\": ";
}

std::string text(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

Mat3 rotationFromEntry(const CameraEntry& entry, const std::string& where) {
  for (const double value : entry.rotation)
    if (!std::isfinite(value)) throw Error(where + "rotation contains a value that is not finite");
  if (entry.rotation.size() == 3)
    return rotationFromVector({entry.rotation[0], entry.rotation[1], entry.rotation[2]});
  if (entry.rotation.size() != 9)
    throw Error(where + "rotation has " + std::to_string(entry.rotation.size()) +
                " values; expected 3 (Rodrigues) or a 3 x 3 matrix");
  const Mat3 matrix = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(entry.rotation.data());
  const double deviation = (matrix.transpose() * matrix - Mat3::Identity()).cwiseAbs().maxCoeff();
  if (!(deviation <= kRotationTolerance) || matrix.determinant() < 0)
    throw Error(where + "rotation is not a rotation matrix (R'R differs from the identity by " +
                text(deviation) + ", the determinant is " + text(matrix.determinant()) +
                "); expected orthonormal rows and determinant +1");
  if (deviation <= kExactRotation) return matrix;
  return Eigen::Quaterniond(matrix).normalized().toRotationMatrix();
}

/// The errors found so far.
struct Diagnostics {
  std::vector<RigDiagnostic> found;

  void add(const std::string& camera, const std::string& what) {
    found.push_back({Severity::kError, camera, what});
  }
};

bool isFinite(const Camera& camera) {
  const Lens& lens = camera.lens;
  const auto finite = [](double value) { return std::isfinite(value); };
  return finite(lens.fx) && finite(lens.fy) && finite(lens.cx) && finite(lens.cy) &&
         std::all_of(lens.distortion.begin(), lens.distortion.end(), finite) &&
         camera.camera_from_world.matrix().allFinite();
}

bool hasImage(const Camera& camera) {
  return camera.width >= kMinImageSide && camera.height >= kMinImageSide && camera.lens.fx > 0 &&
         camera.lens.fy > 0;
}

void checkSize(const Camera& camera, Diagnostics& diagnostics) {
  if (camera.width == 0 && camera.height == 0)
    return diagnostics.add(
        camera.name, "size is missing; expected [width, height] in pixels, or a recording to take it from");
  for (const int side : {camera.width, camera.height})
    if (side < kMinImageSide || side > kMaxImageSide)
      return diagnostics.add(camera.name, "size is " + std::to_string(camera.width) + " x " +
                                              std::to_string(camera.height) + "; expected " +
                                              std::to_string(kMinImageSide) + " to " +
                                              std::to_string(kMaxImageSide) + " pixels per side");
}

void checkCamera(const Camera& camera, Diagnostics& diagnostics) {
  const Lens& lens = camera.lens;
  const std::string& name = camera.name;
  if (name.empty() || name == "." || name == ".." || name.find_first_of("/\\\n\r") != std::string::npos)
    diagnostics.add(name, "name must be usable as a file name: not empty, no slash");
  checkSize(camera, diagnostics);
  if (!(Vec2(lens.fx, lens.fy).allFinite() && Vec2(lens.cx, lens.cy).allFinite()))
    diagnostics.add(name, "matrix contains a value that is not finite");
  else if (!(lens.fx > 0 && lens.fy > 0))
    diagnostics.add(name, "matrix has the focal lengths " + text(lens.fx) + " and " + text(lens.fy) +
                              "; expected positive values, in pixels");
  for (const double value : lens.distortion)
    if (!std::isfinite(value)) {
      diagnostics.add(name, "distortions contain a value that is not finite");
      break;
    }
  const Mat3 rotation = camera.camera_from_world.linear();
  if (!rotation.allFinite())
    diagnostics.add(name, "rotation contains a value that is not finite");
  else if (!(rotation.transpose() * rotation).isIdentity(kRotationTolerance) || rotation.determinant() < 0)
    diagnostics.add(name, "rotation is not a rotation matrix");
  if (!camera.camera_from_world.translation().allFinite())
    diagnostics.add(name, "translation contains a value that is not finite");
}

/// Whether any point of a grid over the cube, including its corners and centre, projects into the image.
bool seesSome(const Camera& camera, const Workspace& workspace) {
  constexpr int kSteps = 16;  // edge/16: even a telephoto lens sees a larger part of the cube
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; ++j)
      for (int k = 0; k <= kSteps; ++k) {
        const Vec3 offset = Vec3(i, j, k) / kSteps - Vec3::Constant(0.5);
        if (project(camera, workspace.center + workspace.edge_m * offset)) return true;
      }
  return false;
}

Vec3 centerInWorld(const Camera& camera) {
  return camera.camera_from_world.inverse().translation();
}

/// Checks a camera's position and view. \pre its values are finite
void checkPosition(const Rig& rig, size_t index, Diagnostics& diagnostics) {
  const double edge = rig.workspace.edge_m;
  const Camera& camera = rig.cameras[index];
  const Vec3 from_center = centerInWorld(camera) - rig.workspace.center;
  if (from_center.cwiseAbs().maxCoeff() <= edge / 2)
    diagnostics.add(camera.name, "it is inside the workspace cube (edge " + text(edge) +
                                     " m); expected a [workspace] that all cameras see from outside");
  if (from_center.norm() > 1000 * edge)
    diagnostics.add(camera.name, "it is " + text(from_center.norm()) +
                                     " m from the workspace's centre; expected at most 1,000 edges (" +
                                     text(1000 * edge) + " m): are the units those of the translations?");
  for (size_t j = 0; j < index; ++j) {
    if (!isFinite(rig.cameras[j])) continue;
    const double apart = (centerInWorld(camera) - centerInWorld(rig.cameras[j])).norm();
    if (apart < edge / 100)
      diagnostics.add(camera.name,
                      "it is " + text(apart * 1000) + " mm from camera \"" + rig.cameras[j].name +
                          "\"; expected at least 1/100 of the workspace's edge (" + text(edge * 10) + " mm)");
  }
  if (hasImage(camera) && !seesSome(camera, rig.workspace))
    diagnostics.add(camera.name, "it sees nothing of the workspace cube (edge " + text(edge) +
                                     " m); expected a [workspace] in every camera's image");
}

}  // namespace

bool isVideoName(const std::string& file) {
  std::string extension = std::filesystem::path(file).extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return std::any_of(kVideoExtensions.begin(), kVideoExtensions.end(),
                     [&](const char* known) { return extension == known; });
}

std::string cameraNameOf(const std::string& name) {
  if (!isVideoName(name)) return name;
  const std::size_t slash = name.find_last_of("/\\");
  const std::string file = slash == std::string::npos ? name : name.substr(slash + 1);
  return isVideoName(file) ? std::filesystem::path(file).stem().string() : name;
}

void checkDistortions(const CameraEntry& entry, const std::string& place, const std::string& where) {
  const std::vector<double>& k = entry.distortions;
  const size_t count = k.size();
  const std::string has = cameraIn(where, entry.name) + place + " has " + std::to_string(count) + " values";
  const bool is_longer = !entry.fisheye && (count == 12 || count == 14);
  if (!is_longer && (entry.fisheye ? count != 4 : count != 4 && count != 5 && count != 8))
    throw Error(has + "; expected " + (entry.fisheye ? "4 (fisheye)" : "4, 5 or 8"));
  if (is_longer && std::any_of(k.begin() + 8, k.end(), [](double value) { return value != 0; }))
    throw Error(has +
                ", and the thin prism or tilt coefficients (the 9th and later) are not 0; expected the "
                "rational model of 8 coefficients: calibrate with `airclay calibrate`, or in OpenCV with "
                "CALIB_RATIONAL_MODEL alone");
}

Camera cameraFromEntry(const CameraEntry& entry, const std::string& where) {
  const std::string here = cameraIn(where, entry.name);
  if (!entry.matrix.allFinite()) throw Error(here + "matrix contains a value that is not finite");
  const Mat3& m = entry.matrix;
  const bool is_valid = std::abs(m(0, 1)) <= 1e-9 * std::abs(m(0, 0)) && m(1, 0) == 0 && m(2, 0) == 0 &&
                        m(2, 1) == 0 && m(2, 2) == 1;
  if (!is_valid) throw Error(here + "matrix must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], without skew");
  const std::vector<double>& k = entry.distortions;
  for (const double value : k)
    if (!std::isfinite(value)) throw Error(here + "distortions contain a value that is not finite");
  checkDistortions(entry, "distortions", where);

  Camera camera;
  camera.name = cameraNameOf(entry.name);
  camera.width = entry.width;
  camera.height = entry.height;
  camera.lens.model = entry.fisheye ? LensModel::kFisheye : LensModel::kPerspective;
  camera.lens.fx = m(0, 0), camera.lens.fy = m(1, 1), camera.lens.cx = m(0, 2), camera.lens.cy = m(1, 2);
  std::copy_n(k.begin(), std::min(k.size(), camera.lens.distortion.size()), camera.lens.distortion.begin());
  camera.lens = withMonotonicRange(camera.lens);
  camera.camera_from_world.linear() = rotationFromEntry(entry, here);
  camera.camera_from_world.translation() = entry.translation_m;
  return camera;
}

std::string diagnosticMessage(const RigDiagnostic& diagnostic, const std::string& where) {
  const std::string& message = diagnostic.message;
  if (!diagnostic.camera.empty()) return cameraIn(where, diagnostic.camera) + message;
  return message.starts_with(where + "/") ? message : where + ": " + message;
}

RigDiagnostic diagnosticFromError(const Error& error, const std::string& where) {
  RigDiagnostic diagnostic{Severity::kError, "", error.what()};
  std::string& message = diagnostic.message;
  if (message.starts_with(where + ": ")) message.erase(0, where.size() + 2);
  const std::string before = "camera \"", after = "\": ";
  const size_t end = message.find(after);
  if (!message.starts_with(before) || end == std::string::npos) return diagnostic;
  diagnostic.camera = message.substr(before.size(), end - before.size());
  message.erase(0, end + after.size());
  return diagnostic;
}

std::vector<RigDiagnostic> rigErrors(const Rig& rig) {
  Diagnostics diagnostics;
  const size_t count = rig.cameras.size();
  if (count < 2 || count > kMaxCameras)
    diagnostics.add("", "it has " + std::to_string(count) + (count == 1 ? " camera" : " cameras") +
                            "; expected 2 to " + std::to_string(kMaxCameras));
  const Workspace& workspace = rig.workspace;
  const bool has_cube = workspace.center.allFinite() && workspace.edge_m >= 1e-3 && workspace.edge_m <= 1e4;
  if (!has_cube) diagnostics.add("", "[workspace] must have a finite center and an edge of 0.001 to 10000 m");
  if (count > kMaxCameras) return diagnostics.found;  // the wrong file: no line for each of its cameras
  for (size_t i = 0; i < count; ++i) {
    const Camera& camera = rig.cameras[i];
    checkCamera(camera, diagnostics);
    for (size_t j = 0; j < i; ++j)
      if (camera.name == rig.cameras[j].name) {
        diagnostics.add("", "two cameras are named \"" + camera.name + "\"; expected unique names");
        break;
      }
  }
  for (size_t i = 0; has_cube && i < count; ++i)
    if (isFinite(rig.cameras[i])) checkPosition(rig, i, diagnostics);
  return diagnostics.found;
}

bool isMeasurable(const Rig& rig) {
  return rig.workspace.center.allFinite() && rig.workspace.edge_m > 0 &&
         std::isfinite(rig.workspace.edge_m) &&
         std::all_of(rig.cameras.begin(), rig.cameras.end(),
                     [](const Camera& camera) { return isFinite(camera) && hasImage(camera); });
}

void checkRig(const Rig& rig, const std::filesystem::path& file) {
  const std::vector<RigDiagnostic> errors = rigErrors(rig);
  if (!errors.empty()) throw Error(diagnosticMessage(errors.front(), file.string()));
}

const Rig& ParsedRig::validRig() const {
  if (!errors.empty()) throw Error(diagnosticMessage(errors.front(), where));
  return rig;
}

}  // namespace airclay
