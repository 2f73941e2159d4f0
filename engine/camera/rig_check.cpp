// SPDX-License-Identifier: MIT
// Whether a rig can be real: what a mistyped or mixed-up calibration looks like before any image is
// decoded.
#include <algorithm>
#include <cmath>
#include <sstream>

#include "engine/camera/camera_name.h"
#include "engine/camera/rig_diagnostics.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

// How far RᵀR may stray from I and still be a rotation printed with few digits.
constexpr double kRotationTolerance = 1e-3;
// Such a matrix was written by somebody who computes in double: it is taken to the last bit.
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
    if (!std::isfinite(value)) throw Error(where + "rotation holds a value that is no finite number");
  if (entry.rotation.size() == 3)
    return rotationFromVector({entry.rotation[0], entry.rotation[1], entry.rotation[2]});
  if (entry.rotation.size() != 9)
    throw Error(where + "rotation has " + std::to_string(entry.rotation.size()) +
                " values; 3 (Rodrigues) or a 3 x 3 matrix would be right");
  const Mat3 matrix = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(entry.rotation.data());
  const double stray = (matrix.transpose() * matrix - Mat3::Identity()).cwiseAbs().maxCoeff();
  if (!(stray <= kRotationTolerance) || matrix.determinant() < 0)
    throw Error(where + "rotation is a matrix that is no rotation (R'R is off the identity by " +
                text(stray) + ", the determinant is " + text(matrix.determinant()) +
                "); orthonormal rows and determinant +1 would be right");
  if (stray <= kExactRotation) return matrix;
  return Eigen::Quaterniond(matrix).normalized().toRotationMatrix();
}

/// The faults found so far.
struct Faults {
  std::vector<RigDiagnostic> found;

  void add(const std::string& camera, const std::string& what) {
    found.push_back({Severity::kFault, camera, what});
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

void checkSize(const Camera& camera, Faults& faults) {
  if (camera.width == 0 && camera.height == 0)
    return faults.add(
        camera.name,
        "size is missing; [width, height] in pixels, or a recording that says it, would be right");
  for (const int side : {camera.width, camera.height})
    if (side < kMinImageSide || side > kMaxImageSide)
      return faults.add(camera.name, "size is " + std::to_string(camera.width) + " x " +
                                         std::to_string(camera.height) + "; " +
                                         std::to_string(kMinImageSide) + " to " +
                                         std::to_string(kMaxImageSide) + " pixels a side would be right");
}

void checkCamera(const Camera& camera, Faults& faults) {
  const Lens& lens = camera.lens;
  const std::string& name = camera.name;
  if (name.empty() || name == "." || name == ".." || name.find_first_of("/\\\n\r") != std::string::npos)
    faults.add(name, "name must be usable as a file's name: no slash, not empty");
  checkSize(camera, faults);
  if (!(Vec2(lens.fx, lens.fy).allFinite() && Vec2(lens.cx, lens.cy).allFinite()))
    faults.add(name, "matrix holds a value that is no finite number");
  else if (!(lens.fx > 0 && lens.fy > 0))
    faults.add(name, "matrix has the focal lengths " + text(lens.fx) + " and " + text(lens.fy) +
                         "; positive ones, in pixels, would be right");
  for (const double value : lens.distortion)
    if (!std::isfinite(value)) {
      faults.add(name, "distortions hold a value that is no finite number");
      break;
    }
  const Mat3 rotation = camera.camera_from_world.linear();
  if (!rotation.allFinite())
    faults.add(name, "rotation holds a value that is no finite number");
  else if (!(rotation.transpose() * rotation).isIdentity(kRotationTolerance) || rotation.determinant() < 0)
    faults.add(name, "rotation is a matrix that is no rotation");
  if (!camera.camera_from_world.translation().allFinite())
    faults.add(name, "translation holds a value that is no finite number");
}

/// Whether any of a grid's points in the cube, its corners and centre among them, falls into the image.
bool seesSome(const Camera& camera, const Workspace& workspace) {
  constexpr int kSteps = 16;  // edge/16: what a telephoto lens sees of the cube is larger than that
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; ++j)
      for (int k = 0; k <= kSteps; ++k) {
        const Vec3 share = Vec3(i, j, k) / kSteps - Vec3::Constant(0.5);
        if (project(camera, workspace.center + workspace.edge_m * share)) return true;
      }
  return false;
}

Vec3 centerInWorld(const Camera& camera) {
  return camera.camera_from_world.inverse().translation();
}

/// Where a camera stands and what it sees, if those can be said at all.
void checkPlace(const Rig& rig, size_t index, Faults& faults) {
  const double edge = rig.workspace.edge_m;
  const Camera& camera = rig.cameras[index];
  const Vec3 from_center = centerInWorld(camera) - rig.workspace.center;
  if (from_center.cwiseAbs().maxCoeff() <= edge / 2)
    faults.add(camera.name, "it stands inside the workspace's cube (edge " + text(edge) +
                                " m); a [workspace] that all cameras look at from outside would be right");
  if (from_center.norm() > 1000 * edge)
    faults.add(camera.name, "it stands " + text(from_center.norm()) +
                                " m from the workspace's centre; at most 1,000 edges (" + text(1000 * edge) +
                                " m) would be right: are the units those of the translations?");
  for (size_t j = 0; j < index; ++j) {
    if (!isFinite(rig.cameras[j])) continue;
    const double apart = (centerInWorld(camera) - centerInWorld(rig.cameras[j])).norm();
    if (apart < edge / 100)
      faults.add(camera.name, "it stands " + text(apart * 1000) + " mm from camera \"" + rig.cameras[j].name +
                                  "\"; at least a hundredth of the workspace's edge (" + text(edge * 10) +
                                  " mm) would be right");
  }
  if (hasImage(camera) && !seesSome(camera, rig.workspace))
    faults.add(camera.name, "it sees nothing of the workspace's cube (edge " + text(edge) +
                                " m); a [workspace] in every camera's image would be right");
}

}  // namespace

bool isVideoName(const std::string& file) {
  std::string ending = std::filesystem::path(file).extension().string();
  for (char& c : ending)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return std::any_of(kVideoEndings.begin(), kVideoEndings.end(),
                     [&](const char* known) { return ending == known; });
}

std::string cameraNameOf(const std::string& name) {
  if (!isVideoName(name)) return name;
  const std::size_t slash = name.find_last_of("/\\");
  const std::string file = slash == std::string::npos ? name : name.substr(slash + 1);
  return isVideoName(file) ? std::filesystem::path(file).stem().string() : name;
}

Camera cameraFromEntry(const CameraEntry& entry, const std::string& where) {
  const std::string here = cameraIn(where, entry.name);
  if (!entry.matrix.allFinite()) throw Error(here + "matrix holds a value that is no finite number");
  const Mat3& m = entry.matrix;
  const bool has_form = std::abs(m(0, 1)) <= 1e-9 * std::abs(m(0, 0)) && m(1, 0) == 0 && m(2, 0) == 0 &&
                        m(2, 1) == 0 && m(2, 2) == 1;
  if (!has_form) throw Error(here + "matrix must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], without skew");
  const std::vector<double>& k = entry.distortions;
  for (const double value : k)
    if (!std::isfinite(value)) throw Error(here + "distortions hold a value that is no finite number");
  const size_t count = k.size();
  const bool is_longer = !entry.fisheye && (count == 12 || count == 14);
  if (!is_longer && (entry.fisheye ? count != 4 : count != 4 && count != 5 && count != 8))
    throw Error(here + "distortions has " + std::to_string(count) + " values; " +
                (entry.fisheye ? "4 (fisheye)" : "4, 5 or 8") + " would be right");
  if (is_longer && std::any_of(k.begin() + 8, k.end(), [](double value) { return value != 0; }))
    throw Error(here + "distortions has " + std::to_string(count) +
                " values, of which the 9th and later (thin prism, tilt) are not 0; a lens of 4, 5 or 8 would "
                "be right");

  Camera camera;
  camera.name = cameraNameOf(entry.name);
  camera.width = entry.width;
  camera.height = entry.height;
  camera.lens.model = entry.fisheye ? LensModel::kFisheye : LensModel::kPerspective;
  camera.lens.fx = m(0, 0), camera.lens.fy = m(1, 1), camera.lens.cx = m(0, 2), camera.lens.cy = m(1, 2);
  std::copy_n(k.begin(), std::min(count, camera.lens.distortion.size()), camera.lens.distortion.begin());
  camera.lens = withMonotonicRange(camera.lens);
  camera.camera_from_world.linear() = rotationFromEntry(entry, here);
  camera.camera_from_world.translation() = entry.translation_m;
  return camera;
}

std::string faultMessage(const RigDiagnostic& finding, const std::string& where) {
  if (!finding.camera.empty()) return cameraIn(where, finding.camera) + finding.what;
  return finding.what.starts_with(where + "/") ? finding.what : where + ": " + finding.what;
}

RigDiagnostic faultFrom(const Error& error, const std::string& where) {
  RigDiagnostic fault{Severity::kFault, "", error.what()};
  std::string& what = fault.what;
  if (what.starts_with(where + ": ")) what.erase(0, where.size() + 2);
  const std::string before = "camera \"", after = "\": ";
  const size_t end = what.find(after);
  if (!what.starts_with(before) || end == std::string::npos) return fault;
  fault.camera = what.substr(before.size(), end - before.size());
  what.erase(0, end + after.size());
  return fault;
}

std::vector<RigDiagnostic> rigErrors(const Rig& rig) {
  Faults faults;
  const size_t count = rig.cameras.size();
  if (count < 2 || count > kMaxCameras)
    faults.add("", "it has " + std::to_string(count) + (count == 1 ? " camera" : " cameras") + "; 2 to " +
                       std::to_string(kMaxCameras) + " would be right");
  const Workspace& workspace = rig.workspace;
  const bool has_cube = workspace.center.allFinite() && workspace.edge_m >= 1e-3 && workspace.edge_m <= 1e4;
  if (!has_cube) faults.add("", "[workspace] must have a finite center and an edge of 0.001 to 10000 m");
  if (count > kMaxCameras) return faults.found;  // a mistaken file: not a line for each of its cameras
  for (size_t i = 0; i < count; ++i) {
    const Camera& camera = rig.cameras[i];
    checkCamera(camera, faults);
    for (size_t j = 0; j < i; ++j)
      if (camera.name == rig.cameras[j].name) {
        faults.add("", "two cameras are named \"" + camera.name + "\"; a name for each would be right");
        break;
      }
  }
  for (size_t i = 0; has_cube && i < count; ++i)
    if (isFinite(rig.cameras[i])) checkPlace(rig, i, faults);
  return faults.found;
}

bool canBeMeasured(const Rig& rig) {
  return rig.workspace.center.allFinite() && rig.workspace.edge_m > 0 &&
         std::isfinite(rig.workspace.edge_m) &&
         std::all_of(rig.cameras.begin(), rig.cameras.end(),
                     [](const Camera& camera) { return isFinite(camera) && hasImage(camera); });
}

void checkRig(const Rig& rig, const std::filesystem::path& file) {
  const std::vector<RigDiagnostic> faults = rigErrors(rig);
  if (!faults.empty()) throw Error(faultMessage(faults.front(), file.string()));
}

const Rig& RigReading::rigWithoutFaults() const {
  if (!faults.empty()) throw Error(faultMessage(faults.front(), where));
  return rig;
}

}  // namespace airclay
