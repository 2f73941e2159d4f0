// SPDX-License-Identifier: MIT
// Whether a rig can be real: what a mistyped or mixed-up calibration looks like before any picture is
// decoded.
#include <cmath>
#include <sstream>

#include "engine/error.h"
#include "engine/rig.h"

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

void checkCamera(const Camera& camera, const std::string& where) {
  const Lens& lens = camera.lens;
  if (camera.name.empty() || camera.name == "." || camera.name == ".." ||
      camera.name.find_first_of("/\\\n\r") != std::string::npos)
    throw Error(where + "name must be usable as a file's name: no slash, not empty");
  for (const int side : {camera.width, camera.height})
    if (side < kMinPictureSide || side > kMaxPictureSide)
      throw Error(where + "size is " + std::to_string(camera.width) + " x " + std::to_string(camera.height) +
                  "; " + std::to_string(kMinPictureSide) + " to " + std::to_string(kMaxPictureSide) +
                  " pixels a side would be right");
  for (const double value : {lens.fx, lens.fy, lens.cx, lens.cy})
    if (!std::isfinite(value)) throw Error(where + "matrix holds a value that is no finite number");
  if (!(lens.fx > 0 && lens.fy > 0))
    throw Error(where + "matrix has the focal lengths " + text(lens.fx) + " and " + text(lens.fy) +
                "; positive ones, in pixels, would be right");
  for (const double value : lens.distortion)
    if (!std::isfinite(value)) throw Error(where + "distortions hold a value that is no finite number");
  if (!camera.camera_from_world.linear().allFinite())
    throw Error(where + "rotation holds a value that is no finite number");
  const Mat3 rotation = camera.camera_from_world.linear();
  if (!(rotation.transpose() * rotation).isIdentity(kRotationTolerance) || rotation.determinant() < 0)
    throw Error(where + "rotation is a matrix that is no rotation");
  if (!camera.camera_from_world.translation().allFinite())
    throw Error(where + "translation holds a value that is no finite number");
}

/// Whether any of a grid's points in the cube, its corners and centre among them, falls into the picture.
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

void checkPlaces(const Rig& rig, const std::string& file) {
  const double edge = rig.workspace.edge_m;
  for (size_t i = 0; i < rig.cameras.size(); ++i) {
    const Camera& camera = rig.cameras[i];
    const std::string where = cameraIn(file, camera.name);
    const Vec3 from_center = centerInWorld(camera) - rig.workspace.center;
    if (from_center.cwiseAbs().maxCoeff() <= edge / 2)
      throw Error(where + "it stands inside the workspace's cube (edge " + text(edge) +
                  " m); a [workspace] that all cameras look at from outside would be right");
    if (from_center.norm() > 1000 * edge)
      throw Error(where + "it stands " + text(from_center.norm()) +
                  " m from the workspace's centre; at most 1,000 edges (" + text(1000 * edge) +
                  " m) would be right: are the units those of the translations?");
    for (size_t j = 0; j < i; ++j) {
      const double apart = (centerInWorld(camera) - centerInWorld(rig.cameras[j])).norm();
      if (apart < edge / 100)
        throw Error(where + "it stands " + text(apart * 1000) + " mm from camera \"" + rig.cameras[j].name +
                    "\"; at least a hundredth of the workspace's edge (" + text(edge * 10) +
                    " mm) would be right");
    }
    if (!seesSome(camera, rig.workspace))
      throw Error(where + "it sees nothing of the workspace's cube (edge " + text(edge) +
                  " m); a [workspace] in every camera's picture would be right");
  }
}

}  // namespace

Camera cameraFromEntry(const CameraEntry& entry, const std::string& where) {
  const std::string here = cameraIn(where, entry.name);
  if (!entry.matrix.allFinite()) throw Error(here + "matrix holds a value that is no finite number");
  const Mat3& m = entry.matrix;
  const bool has_form = std::abs(m(0, 1)) <= 1e-9 * std::abs(m(0, 0)) && m(1, 0) == 0 && m(2, 0) == 0 &&
                        m(2, 1) == 0 && m(2, 2) == 1;
  if (!has_form) throw Error(here + "matrix must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], without skew");
  const size_t count = entry.distortions.size();
  if (entry.fisheye ? count != 4 : count != 4 && count != 5 && count != 8)
    throw Error(here + "distortions has " + std::to_string(count) + " values; " +
                (entry.fisheye ? "4 (fisheye)" : "4, 5 or 8") + " would be right");

  Camera camera;
  camera.name = entry.name;
  camera.width = entry.width;
  camera.height = entry.height;
  camera.lens.model = entry.fisheye ? LensModel::kFisheye : LensModel::kPerspective;
  camera.lens.fx = m(0, 0), camera.lens.fy = m(1, 1), camera.lens.cx = m(0, 2), camera.lens.cy = m(1, 2);
  for (size_t i = 0; i < count; ++i) {
    if (!std::isfinite(entry.distortions[i]))
      throw Error(here + "distortions hold a value that is no finite number");
    camera.lens.distortion[i] = entry.distortions[i];
  }
  camera.lens = withMonotonicRange(camera.lens);
  camera.camera_from_world.linear() = rotationFromEntry(entry, here);
  camera.camera_from_world.translation() = entry.translation_m;
  return camera;
}

void checkRig(const Rig& rig, const std::filesystem::path& file) {
  const std::string where = file.string();
  const size_t count = rig.cameras.size();
  if (count < 2 || count > kMaxCameras)
    throw Error(where + ": it has " + std::to_string(count) + (count == 1 ? " camera" : " cameras") +
                "; 2 to " + std::to_string(kMaxCameras) + " would be right");
  if (!rig.workspace.center.allFinite() || !(rig.workspace.edge_m >= 1e-3 && rig.workspace.edge_m <= 1e4))
    throw Error(where + ": [workspace] must have a finite center and an edge of 0.001 to 10000 m");
  for (size_t i = 0; i < count; ++i) {
    checkCamera(rig.cameras[i], cameraIn(where, rig.cameras[i].name));
    for (size_t j = 0; j < i; ++j)
      if (rig.cameras[i].name == rig.cameras[j].name)
        throw Error(where + ": two cameras are named \"" + rig.cameras[i].name +
                    "\"; a name for each would be right");
  }
  checkPlaces(rig, where);
}

}  // namespace airclay
