// SPDX-License-Identifier: MIT
// What a rig looks like from the workspace, and what in it is more often a mistake than meant.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "engine/camera/rig_diagnostics.h"

namespace airclay {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

// A camera's principal point is that far from the image's centre, in image widths, when it was made so:
// webcams stay within 5 %.
constexpr double kFarPrincipalPoint = 0.15;
// Pixels of cameras are square to a thousandth; calibrations of few views stray by 1 or 2 %.
constexpr double kUnequalFocalLengths = 0.03;
// A telephoto lens, and what a perspective model can still describe.
constexpr double kNarrowView_deg = 10, kWideView_deg = 150;
// 3 mm a pixel: a finger is 5 pixels wide.
constexpr double kFewPixelsPerMm = 1.0 / 3;
// Two rays that meet at less than this leave the depth 6 times as uncertain as the width.
constexpr double kNarrowAngle_deg = 10;
// So much of the cube must be seen by two cameras: elsewhere there is no hull.
constexpr double kEnoughOfCube = 0.7;
// Cameras that many edges away are hardly meant: at 30 edges the cube is 20 pixels wide.
constexpr double kFarCamera = 30;

std::string text(double value, int digits = 3) {
  std::ostringstream out;
  out.precision(digits);
  out << value;
  return out.str();
}

std::string percent(double share) {
  return text(std::round(100 * share)) + " %";
}

/// As --center takes it, to a millimetre.
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

/// The centres of the cube's 14³ parts.
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
  // The lens ends within the image: what it shows is twice its range.
  const double limit = lens.monotonic_limit;
  return 2 * kDegrees * (lens.model == LensModel::kFisheye ? limit : std::atan(limit));
}

double pixelsPerMm(const Camera& camera, const Vec3& center) {
  const Vec3 center_in_camera = camera.camera_from_world * center;
  const std::optional<Vec2> at = projectThroughLens(camera.lens, center_in_camera);
  const std::optional<Vec2> beside = projectThroughLens(camera.lens, center_in_camera + Vec3(1e-3, 0, 0));
  if (at && beside) return (*beside - *at).norm();
  return 1e-3 * camera.lens.fx / center_in_camera.norm();
}

/// The largest angle at which two cameras' lines of sight meet in the cube's centre, folded: opposite cameras
/// are as bad as neighbours.
double widestAngleDegrees(const Rig& rig) {
  double widest = 0;
  for (size_t i = 0; i < rig.cameras.size(); ++i)
    for (size_t j = 0; j < i; ++j) {
      const Vec3 a = centerInWorld(rig.cameras[i]) - rig.workspace.center;
      const Vec3 b = centerInWorld(rig.cameras[j]) - rig.workspace.center;
      widest = std::max(widest, kDegrees * std::atan2(a.cross(b).norm(), std::abs(a.dot(b))));
    }
  return widest;
}

double meanSeenShare(const RigFigures& figures) {
  double sum = 0;
  for (const CameraFigures& camera : figures.cameras) sum += camera.seen_share;
  return sum / static_cast<double>(std::max<size_t>(figures.cameras.size(), 1));
}

double medianDistance(const RigFigures& figures) {
  std::vector<double> distances;
  for (const CameraFigures& camera : figures.cameras) distances.push_back(camera.distance_m);
  std::nth_element(distances.begin(), distances.begin() + static_cast<long>(distances.size() / 2),
                   distances.end());
  return distances[distances.size() / 2];
}

/// Looks at one rig, and keeps what is odd.
class Inspection {
 public:
  explicit Inspection(const Rig& rig) : rig_(rig), figures_(measureRig(rig)) {}

  std::vector<RigDiagnostic> all() {
    if (rig_.cameras.empty()) return {};
    for (size_t i = 0; i < rig_.cameras.size(); ++i) {
      inspectImage(rig_.cameras[i]);
      lookAtLens(rig_.cameras[i], figures_.cameras[i]);
    }
    // Each of these explains what the next would say again in other words.
    if (lookAtUnits() || lookAtPoses()) return std::move(found_);
    for (size_t i = 0; i < rig_.cameras.size(); ++i) lookAtView(rig_.cameras[i], figures_.cameras[i]);
    lookAtWorld();
    lookAtCoverage();
    return std::move(found_);
  }

 private:
  void add(const std::string& camera, const std::string& what) {
    found_.push_back({Severity::kWarning, camera, what});
  }

  /// Whether matrix and size are of the same image.
  void inspectImage(const Camera& camera) {
    const Lens& lens = camera.lens;
    const double w = camera.width, h = camera.height;
    const auto isCentre = [](double principal, double side) {
      return std::abs(principal - 0.5 * (side - 1)) <= kFarPrincipalPoint * side;
    };
    if (!isCentre(lens.cx, w) || !isCentre(lens.cy, h)) {
      const double scale_x = (lens.cx + 0.5) / (0.5 * w), scale_y = (lens.cy + 0.5) / (0.5 * h);
      std::string right = "a matrix of images of this size would be right";
      if (isCentre(lens.cx, h) && isCentre(lens.cy, w))
        right = "are width and height exchanged, or the images turned by 90 degrees?";
      else if (std::abs(scale_x / scale_y - 1) < 0.1)
        right = "is the matrix of images " + text(scale_x, 2) + " times as large?";
      add(camera.name, "its principal point (" + text(lens.cx) + ", " + text(lens.cy) +
                           ") is far from the centre of " + text(w, 5) + " x " + text(h, 5) + " pixels; " +
                           right);
    }
    if (std::abs(lens.fx / lens.fy - 1) > kUnequalFocalLengths)
      add(camera.name, "its focal lengths differ, " + text(lens.fx, 4) + " and " + text(lens.fy, 4) +
                           " pixels; equal ones to 1 % would be right, unless the images are stretched");
  }

  void lookAtLens(const Camera& camera, const CameraFigures& figures) {
    if (figures.view_deg < kNarrowView_deg || figures.view_deg > kWideView_deg)
      add(camera.name, "it sees an angle of " + text(figures.view_deg) +
                           " degrees; is the focal length in pixels of this image?");
    int blind = 0, all = 0;
    constexpr int kSteps = 24;
    for (int i = 0; i <= kSteps; ++i)
      for (int j = 0; j <= kSteps; ++j, ++all)
        blind += !rayThroughPixel(camera.lens,
                                  {i * (camera.width - 1.0) / kSteps, j * (camera.height - 1.0) / kSteps});
    if (blind)
      add(camera.name, "its lens model ends inside the image: " + percent(double(blind) / all) +
                           " of the pixels have no ray; fewer distortion coefficients, or a calibration with "
                           "views up to the corners, would be right");
  }

  /// The workspace is in metres; the translations may not have been.
  bool lookAtUnits() {
    const double edge = rig_.workspace.edge_m, distance = medianDistance(figures_);
    const auto isPlausible = [&](double metres) { return metres > 0.7 * edge && metres < 10 * edge; };
    const std::string seen = "the cameras stand " + text(distance, 4) +
                             " m from the cube's centre, its edge is " + text(edge) + " m; ";
    if (distance > kFarCamera * edge) {
      for (const auto& [factor, unit] : {std::pair{1e-3, "millimetres: units = \"mm\""},
                                         std::pair{1e-2, "centimetres: translations in m or mm"}})
        if (isPlausible(factor * distance)) {
          add("", seen + "the translations are probably " + unit + " would be right");
          return true;
        }
      add("", seen + "are units and [workspace] right?");
      return true;
    }
    if (distance < 0.3 * edge && isPlausible(1e3 * distance)) {
      add("", seen + "the translations are probably metres: units = \"m\" would be right");
      return true;
    }
    return false;
  }

  /// Poses that see little of the cube, and much of it when they are taken for something else.
  bool lookAtPoses() {
    const double seen = meanSeenShare(figures_);
    std::optional<PoseReading> best;
    double best_seen = std::max(0.3, 2 * seen);
    for (const PoseReading poses : kPoseReadings) {
      const double other = meanSeenShare(measureRig(reread(rig_, poses)));
      if (other > best_seen) best = poses, best_seen = other;
    }
    if (seen > 0.3 || !best) return false;
    add("", "the cameras see " + percent(seen) + " of the cube, and " + percent(best_seen) +
                " if the poses are " + wordsOf(*best) +
                "; camera_from_world with x right, y down, z forward would be right");
    return true;
  }

  void lookAtView(const Camera& camera, const CameraFigures& figures) {
    if (figures.seen_share == 0) return;  // a fault, said there
    if (!project(camera, rig_.workspace.center))
      add(camera.name, "it does not see the cube's centre; turn it there, or move [workspace] center");
    if (figures.pixels_per_mm < kFewPixelsPerMm)
      add(camera.name, "a pixel is " + text(1 / figures.pixels_per_mm) +
                           " mm at the cube's centre; a nearer camera or a larger image would be right");
  }

  /// Up is z. A board's own frame, which many rigs are left in, has z into the board.
  void lookAtWorld() {
    double up = 0, height = 0;
    bool all_below = true;
    for (const Camera& camera : rig_.cameras) {
      up += -camera.camera_from_world.linear()(1, 2) / static_cast<double>(rig_.cameras.size());
      height = centerInWorld(camera).z() - rig_.workspace.center.z();
      all_below = all_below && height < 0;
    }
    if (up < -0.3 && all_below)
      add("",
          "all cameras are upside down and below the cube: the world's z points down; a world with z up "
          "would be right");
    else if (up < -0.5)
      add("", "the cameras are upside down on average; a world with z up would be right");
    else if (all_below)
      add("", "all cameras stand below the cube's centre; is the world's z up?");
  }

  /// Whether the cube lies where the cameras look.
  void lookAtCoverage() {
    const double edge = rig_.workspace.edge_m;
    const bool one_is_inside =
        std::any_of(rig_.cameras.begin(), rig_.cameras.end(), [&](const Camera& camera) {
          return (centerInWorld(camera) - rig_.workspace.center).cwiseAbs().maxCoeff() <= edge / 2;
        });
    const bool is_little = figures_.seen_by_two < kEnoughOfCube;
    const std::optional<Vec3> meet = whereAxesMeet(rig_);
    const bool looks_elsewhere = meet && (*meet - rig_.workspace.center).norm() > edge / 2;
    if (looks_elsewhere && (is_little || one_is_inside))
      add("", "the cameras' axes come nearest to each other at " + centerText(*meet) +
                  "; [workspace] center there, or --center, would be right");
    else if (is_little)
      add("", "two cameras or more see only " + percent(figures_.seen_by_two) +
                  " of the cube; a smaller [workspace] edge, or cameras farther back, would be right");
    if (rig_.cameras.size() < 2) return;
    const double angle = widestAngleDegrees(rig_);
    if (angle < kNarrowAngle_deg)
      add("", "no two cameras look at the cube's centre at more than " + text(angle) +
                  " degrees to each other; 30 to 150 would be right, or depth stays uncertain");
  }

  const Rig& rig_;
  const RigFigures figures_;
  std::vector<RigDiagnostic> found_;
};

}  // namespace

RigFigures measureRig(const Rig& rig) {
  const std::vector<Vec3> points = cubePoints(rig.workspace);
  std::vector<int> seen_by(points.size());
  RigFigures figures;
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
  figures.seen_by_two = static_cast<double>(by_two) / static_cast<double>(points.size());
  return figures;
}

std::vector<RigDiagnostic> rigWarnings(const Rig& rig) {
  return Inspection(rig).all();
}

std::optional<Vec3> whereAxesMeet(const Rig& rig) {
  // Least squares of the distances to the lines: sum of (I - d dᵀ)(p - c) is 0.
  Mat3 sum = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (const Camera& camera : rig.cameras) {
    const Vec3 axis = axisInWorld(camera);
    const Mat3 across = Mat3::Identity() - axis * axis.transpose();
    sum += across;
    right += across * centerInWorld(camera);
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(sum);
  // sin² of 2 degrees: flatter, and noise decides
  if (!(eigen.eigenvalues()(0) > 1e-3 * static_cast<double>(rig.cameras.size()))) return std::nullopt;
  const Vec3 point = sum.ldlt().solve(right);
  for (const Camera& camera : rig.cameras)
    if ((camera.camera_from_world * point).z() <= 0) return std::nullopt;
  return point;
}

Rig reread(const Rig& rig, PoseReading poses) {
  Rig result = rig;
  const Mat3 cv_from_gl = Vec3(1, -1, -1).asDiagonal();
  for (Camera& camera : result.cameras) {
    if (poses != PoseReading::kGlCameraFromWorld)
      camera.camera_from_world = camera.camera_from_world.inverse();
    if (poses == PoseReading::kWorldFromCamera) continue;
    camera.camera_from_world.linear() = cv_from_gl * camera.camera_from_world.linear();
    camera.camera_from_world.translation() = cv_from_gl * camera.camera_from_world.translation();
  }
  return result;
}

std::string wordsOf(PoseReading poses) {
  switch (poses) {
    case PoseReading::kWorldFromCamera:
      return "world_from_camera";
    case PoseReading::kGlCameraFromWorld:
      return "of OpenGL's or Blender's cameras (y up, looking along -z)";
    case PoseReading::kWorldFromGlCamera:
      return "world_from_camera, of OpenGL's or Blender's cameras (y up, looking along -z)";
  }
  return "";
}

}  // namespace airclay
