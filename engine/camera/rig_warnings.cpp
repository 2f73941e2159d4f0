// SPDX-License-Identifier: MIT
// Metrics of a rig relative to its workspace, and warnings about probable mistakes.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "engine/camera/rig_diagnostics.h"

namespace airclay {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

// Distance of the principal point from the image centre, as a fraction of the image side. Webcams stay within
// 5 %; more means that matrix and size belong to different images.
constexpr double kMaxPrincipalPointOffset = 0.15;
// Relative difference of fx and fy. Pixels are square to 0.1 %; calibrations from few views are off by 1 or 2
// %.
constexpr double kMaxFocalLengthDifference = 0.03;
// The field of view of a telephoto lens, and the widest that a perspective model can describe.
constexpr double kMinView_deg = 10, kMaxView_deg = 150;
// 3 mm per pixel: a finger is 5 pixels wide.
constexpr double kMinPixelsPerMm = 1.0 / 3;
// For rays that intersect at a smaller angle, depth is over 6 times as uncertain as lateral position.
constexpr double kMinAngle_deg = 10;
// At least this fraction of the cube should be seen by two cameras; there is no hull elsewhere.
constexpr double kMinSeenByTwoFraction = 0.7;
// At 30 edges from the camera the cube is only 20 pixels wide.
constexpr double kMaxCameraDistance_edges = 30;

std::string text(double value, int digits = 3) {
  std::ostringstream out;
  out.precision(digits);
  out << value;
  return out.str();
}

std::string percent(double fraction) {
  return text(std::round(100 * fraction)) + " %";
}

/// In the format of --center, rounded to a millimetre.
std::string centerText(const Vec3& point) {
  const auto rounded = [](double value) { return text(std::round(1000 * value) / 1000 + 0.0, 6); };
  return rounded(point.x()) + "," + rounded(point.y()) + "," + rounded(point.z());
}

Vec3 centerInWorld(const Camera& camera) {
  return camera.camera_from_world.inverse().translation();
}

Vec3 axisInWorld(const Camera& camera) {
  return camera.camera_from_world.linear().row(2).transpose();
}

/// The centres of 14³ cells of the cube.
std::vector<Vec3> cubePoints(const Workspace& workspace) {
  constexpr int kSteps = 14;
  std::vector<Vec3> points;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j)
      for (int k = 0; k < kSteps; ++k)
        points.push_back(workspace.center +
                         workspace.edge_m *
                             ((Vec3(i, j, k) + Vec3::Constant(0.5)) / kSteps - Vec3::Constant(0.5)));
  return points;
}

double viewDegrees(const Camera& camera) {
  const Lens& lens = camera.lens;
  const std::optional<Vec3> left = rayThroughPixel(lens, {-0.5, lens.cy});
  const std::optional<Vec3> right = rayThroughPixel(lens, {camera.width - 0.5, lens.cy});
  if (left && right) return kDegrees * std::atan2(left->cross(*right).norm(), left->dot(*right));
  // The lens model ends inside the image: the view is twice its range.
  const double limit = lens.monotonic_limit;
  return 2 * kDegrees * (lens.model == LensModel::kFisheye ? limit : std::atan(limit));
}

double pixelsPerMm(const Camera& camera, const Vec3& center) {
  const Vec3 center_in_camera = camera.camera_from_world * center;
  const std::optional<Vec2> at = projectThroughLens(camera.lens, center_in_camera);
  const std::optional<Vec2> shifted = projectThroughLens(camera.lens, center_in_camera + Vec3(1e-3, 0, 0));
  if (at && shifted) return (*shifted - *at).norm();
  return 1e-3 * camera.lens.fx / center_in_camera.norm();
}

/// The largest angle between two cameras' lines of sight to the cube's centre, folded to [0, 90]: opposite
/// cameras are as bad as adjacent ones.
double maxAngleDegrees(const Rig& rig) {
  double widest = 0;
  for (size_t i = 0; i < rig.cameras.size(); ++i)
    for (size_t j = 0; j < i; ++j) {
      const Vec3 a = centerInWorld(rig.cameras[i]) - rig.workspace.center;
      const Vec3 b = centerInWorld(rig.cameras[j]) - rig.workspace.center;
      widest = std::max(widest, kDegrees * std::atan2(a.cross(b).norm(), std::abs(a.dot(b))));
    }
  return widest;
}

double meanSeenFraction(const RigMetrics& figures) {
  double sum = 0;
  for (const CameraMetrics& camera : figures.cameras) sum += camera.seen_fraction;
  return sum / static_cast<double>(std::max<size_t>(figures.cameras.size(), 1));
}

double medianDistance(const RigMetrics& figures) {
  std::vector<double> distances;
  for (const CameraMetrics& camera : figures.cameras) distances.push_back(camera.distance_m);
  std::nth_element(distances.begin(), distances.begin() + static_cast<long>(distances.size() / 2),
                   distances.end());
  return distances[distances.size() / 2];
}

/// Collects the warnings of one rig.
class Inspection {
 public:
  explicit Inspection(const Rig& rig) : rig_(rig), figures_(measureRig(rig)) {}

  std::vector<RigDiagnostic> all() {
    if (rig_.cameras.empty()) return {};
    for (size_t i = 0; i < rig_.cameras.size(); ++i) {
      inspectImage(rig_.cameras[i]);
      inspectLens(rig_.cameras[i], figures_.cameras[i]);
    }
    // Each of these causes the later ones; report only the first.
    if (inspectUnits() || inspectPoses()) return std::move(found_);
    for (size_t i = 0; i < rig_.cameras.size(); ++i) inspectView(rig_.cameras[i], figures_.cameras[i]);
    inspectWorld();
    inspectCoverage();
    return std::move(found_);
  }

 private:
  void add(const std::string& camera, const std::string& what) {
    found_.push_back({Severity::kWarning, camera, what});
  }

  /// Whether matrix and size belong to the same image.
  void inspectImage(const Camera& camera) {
    const Lens& lens = camera.lens;
    const double w = camera.width, h = camera.height;
    const auto isCentre = [](double principal, double side) {
      return std::abs(principal - 0.5 * (side - 1)) <= kMaxPrincipalPointOffset * side;
    };
    if (!isCentre(lens.cx, w) || !isCentre(lens.cy, h)) {
      const double scale_x = (lens.cx + 0.5) / (0.5 * w), scale_y = (lens.cy + 0.5) / (0.5 * h);
      std::string right = "expected a matrix for images of this size";
      if (isCentre(lens.cx, h) && isCentre(lens.cy, w))
        right = "are width and height swapped, or the images rotated by 90 degrees?";
      else if (std::abs(scale_x / scale_y - 1) < 0.1)
        right = "does the matrix belong to images " + text(scale_x, 2) + " times as large?";
      add(camera.name, "its principal point (" + text(lens.cx) + ", " + text(lens.cy) +
                           ") is far from the centre of " + text(w, 5) + " x " + text(h, 5) + " pixels; " +
                           right);
    }
    if (std::abs(lens.fx / lens.fy - 1) > kMaxFocalLengthDifference)
      add(camera.name, "its focal lengths differ, " + text(lens.fx, 4) + " and " + text(lens.fy, 4) +
                           " pixels; expected equal values within 1 %, unless the images are stretched");
  }

  void inspectLens(const Camera& camera, const CameraMetrics& figures) {
    if (figures.view_deg < kMinView_deg || figures.view_deg > kMaxView_deg)
      add(camera.name, "its field of view is " + text(figures.view_deg) +
                           " degrees; is the focal length in pixels of this image?");
    int blind = 0, all = 0;
    constexpr int kSteps = 24;
    for (int i = 0; i <= kSteps; ++i)
      for (int j = 0; j <= kSteps; ++j, ++all)
        blind += !rayThroughPixel(camera.lens,
                                  {i * (camera.width - 1.0) / kSteps, j * (camera.height - 1.0) / kSteps});
    if (blind)
      add(camera.name, "its lens model ends inside the image: " + percent(double(blind) / all) +
                           " of the pixels have no ray; use fewer distortion coefficients, or calibrate with "
                           "the board in the image corners too");
  }

  /// The workspace is in metres; the translations may be in another unit.
  bool inspectUnits() {
    const double edge = rig_.workspace.edge_m, distance = medianDistance(figures_);
    const auto isPlausible = [&](double metres) { return metres > 0.7 * edge && metres < 10 * edge; };
    const std::string seen = "the cameras are " + text(distance, 4) +
                             " m from the cube's centre and its edge is " + text(edge) + " m; ";
    if (distance > kMaxCameraDistance_edges * edge) {
      for (const auto& [factor, unit] : {std::pair{1e-3, "millimetres; expected units = \"mm\""},
                                         std::pair{1e-2, "centimetres; expected metres or millimetres"}})
        if (isPlausible(factor * distance)) {
          add("", seen + "the translations are probably in " + unit);
          return true;
        }
      add("", seen + "are units and [workspace] correct?");
      return true;
    }
    if (distance < 0.3 * edge && isPlausible(1e3 * distance)) {
      add("", seen + "the translations are probably in metres; expected units = \"m\"");
      return true;
    }
    return false;
  }

  /// Poses that see little of the cube as they are, and much of it under another convention.
  bool inspectPoses() {
    const double seen = meanSeenFraction(figures_);
    std::optional<PoseConvention> best;
    double best_seen = std::max(0.3, 2 * seen);
    for (const PoseConvention poses : kPoseConventions) {
      const double other = meanSeenFraction(measureRig(withPoseConvention(rig_, poses)));
      if (other > best_seen) best = poses, best_seen = other;
    }
    if (seen > 0.3 || !best) return false;
    add("", "the cameras see " + percent(seen) + " of the cube, but " + percent(best_seen) +
                " if the poses are " + describe(*best) +
                "; expected camera_from_world with x right, y down, z forward");
    return true;
  }

  void inspectView(const Camera& camera, const CameraMetrics& figures) {
    if (figures.seen_fraction == 0) return;  // an error of rigErrors()
    if (!project(camera, rig_.workspace.center))
      add(camera.name, "it does not see the cube's centre; turn the camera, or move [workspace] center");
    if (figures.pixels_per_mm < kMinPixelsPerMm)
      add(camera.name, "a pixel is " + text(1 / figures.pixels_per_mm) +
                           " mm at the cube's centre; move the camera closer or use a higher resolution");
  }

  /// The world's z axis points up. In a board's or a camera's own frame, which many rigs use, it does not.
  void inspectWorld() {
    Vec3 up = Vec3::Zero(), forward = Vec3::Zero();
    bool all_below = true;
    for (const Camera& camera : rig_.cameras) {
      up -= camera.camera_from_world.linear().row(1).transpose() / static_cast<double>(rig_.cameras.size());
      forward += axisInWorld(camera) / static_cast<double>(rig_.cameras.size());
      all_below = all_below && centerInWorld(camera).z() < rig_.workspace.center.z();
    }
    if (inspectUpAxis(up, forward)) return;
    const std::string convert = "expected a world with z up; `airclay rig convert --up=-z` converts the rig";
    if (up.z() < -0.3 && all_below)
      add("", "all cameras are upside down and below the cube: the world's z points down; " + convert);
    else if (up.z() < -0.5)
      add("", "the cameras are upside down on average; " + convert);
    else if (all_below)
      add("", "all cameras are below the cube's centre; does the world's z point up?");
  }

  /// Whether the images are upright along x or y. \param up, forward means of the cameras' directions
  bool inspectUpAxis(const Vec3& up, const Vec3& forward) {
    // Cameras above the cube that look straight down are upright along a horizontal axis.
    constexpr double kClear = 0.6;
    if (forward.z() < -kClear) return false;
    for (const int axis : {0, 1}) {
      if (std::abs(up[axis]) < kClear) continue;
      const std::string name = std::string(up[axis] < 0 ? "-" : "") + "xy"[axis];
      add("", "the cameras' images are upright along " + name + (name == "-y" ? " (a y-down world)" : "") +
                  "; expected a world with z up; `airclay rig convert --up=" + name + "` converts the rig");
      return true;
    }
    return false;
  }

  /// Whether the cube is where the cameras look.
  void inspectCoverage() {
    const double edge = rig_.workspace.edge_m;
    const bool one_is_inside =
        std::any_of(rig_.cameras.begin(), rig_.cameras.end(), [&](const Camera& camera) {
          return (centerInWorld(camera) - rig_.workspace.center).cwiseAbs().maxCoeff() <= edge / 2;
        });
    const bool is_little = figures_.seen_by_two_fraction < kMinSeenByTwoFraction;
    const std::optional<Vec3> meet = axesIntersection(rig_);
    const bool looks_elsewhere = meet && (*meet - rig_.workspace.center).norm() > edge / 2;
    if (looks_elsewhere && (is_little || one_is_inside))
      add("", "the cameras' axes intersect near " + centerText(*meet) +
                  "; set [workspace] center, or --center, to that point");
    else if (is_little)
      add("", "only " + percent(figures_.seen_by_two_fraction) +
                  " of the cube is seen by two or more cameras; reduce [workspace] edge or move the cameras "
                  "back");
    if (rig_.cameras.size() < 2) return;
    const double angle = maxAngleDegrees(rig_);
    if (angle < kMinAngle_deg)
      add("", "the largest angle between two cameras' views of the cube's centre is " + text(angle) +
                  " degrees, which leaves depth uncertain; expected 30 to 150");
  }

  const Rig& rig_;
  const RigMetrics figures_;
  std::vector<RigDiagnostic> found_;
};

}  // namespace

RigMetrics measureRig(const Rig& rig) {
  const std::vector<Vec3> points = cubePoints(rig.workspace);
  std::vector<int> seen_by(points.size());
  RigMetrics figures;
  for (const Camera& camera : rig.cameras) {
    int seen = 0;
    for (size_t i = 0; i < points.size(); ++i)
      if (project(camera, points[i])) ++seen, ++seen_by[i];
    figures.cameras.push_back({camera.name, camera.width, camera.height, viewDegrees(camera),
                               (centerInWorld(camera) - rig.workspace.center).norm(),
                               pixelsPerMm(camera, rig.workspace.center),
                               seen / static_cast<double>(points.size())});
  }
  const auto by_two = std::count_if(seen_by.begin(), seen_by.end(), [](int count) { return count >= 2; });
  figures.seen_by_two_fraction = static_cast<double>(by_two) / static_cast<double>(points.size());
  return figures;
}

std::vector<RigDiagnostic> rigWarnings(const Rig& rig) {
  return Inspection(rig).all();
}

std::optional<Vec3> axesIntersection(const Rig& rig) {
  // Least squares of the distances to the axes: the sum of (I - d dᵀ)(p - c) is 0.
  Mat3 sum = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (const Camera& camera : rig.cameras) {
    const Vec3 axis = axisInWorld(camera);
    const Mat3 across = Mat3::Identity() - axis * axis.transpose();
    sum += across;
    right += across * centerInWorld(camera);
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(sum);
  // about sin² of 2 degrees: below this, noise dominates
  if (!(eigen.eigenvalues()(0) > 1e-3 * static_cast<double>(rig.cameras.size()))) return std::nullopt;
  const Vec3 point = sum.ldlt().solve(right);
  for (const Camera& camera : rig.cameras)
    if ((camera.camera_from_world * point).z() <= 0) return std::nullopt;
  return point;
}

Rig withPoseConvention(const Rig& rig, PoseConvention poses) {
  Rig result = rig;
  const Mat3 cv_from_gl = Vec3(1, -1, -1).asDiagonal();
  for (Camera& camera : result.cameras) {
    if (poses != PoseConvention::kGlCameraFromWorld)
      camera.camera_from_world = camera.camera_from_world.inverse();
    if (poses == PoseConvention::kWorldFromCamera) continue;
    camera.camera_from_world.linear() = cv_from_gl * camera.camera_from_world.linear();
    camera.camera_from_world.translation() = cv_from_gl * camera.camera_from_world.translation();
  }
  return result;
}

std::optional<Vec3> axisNamed(std::string_view name) {
  const double sign = name.starts_with('-') ? -1 : 1;
  if (name.starts_with('-')) name.remove_prefix(1);
  if (name == "x") return Vec3(sign, 0, 0);
  if (name == "y") return Vec3(0, sign, 0);
  if (name == "z") return Vec3(0, 0, sign);
  return std::nullopt;
}

Rig withUpAxis(const Rig& rig, const Vec3& up) {
  Pose new_from_old = Pose::Identity();
  new_from_old.linear() =
      up.z() < -0.5
          ? Mat3(Vec3(1, -1, -1).asDiagonal())
          : Mat3(Eigen::Quaterniond::FromTwoVectors(up, Vec3::UnitZ()).toRotationMatrix().array().round());
  Rig result = rig;
  for (Camera& camera : result.cameras)
    camera.camera_from_world = camera.camera_from_world * new_from_old.inverse();
  result.workspace.center = new_from_old * rig.workspace.center;
  return result;
}

std::string describe(PoseConvention poses) {
  switch (poses) {
    case PoseConvention::kWorldFromCamera:
      return "world_from_camera";
    case PoseConvention::kGlCameraFromWorld:
      return "those of OpenGL or Blender cameras (y up, looking along -z)";
    case PoseConvention::kWorldFromGlCamera:
      return "world_from_camera of OpenGL or Blender cameras (y up, looking along -z)";
  }
  return "";
}

}  // namespace airclay
