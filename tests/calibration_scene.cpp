// SPDX-License-Identifier: MIT
#include "tests/calibration_scene.h"

#include <Eigen/SVD>
#include <cmath>

namespace airclay {
namespace {

Vec3 eyeOf(const Camera& camera) {
  return camera.camera_from_world.inverse().translation();
}

/// A right-handed frame whose z is `forward`.
Mat3 facing(const Vec3& forward, double roll) {
  const Vec3 z = forward.normalized();
  const Vec3 x =
      (z.cross(Vec3::UnitZ()).norm() > 0.05 ? z.cross(Vec3::UnitZ()) : z.cross(Vec3::UnitX())).normalized();
  Mat3 frame;
  frame << x, z.cross(x), z;
  return frame * Eigen::AngleAxisd(roll, Vec3::UnitZ()).toRotationMatrix();
}

/// The point nearest to the rays of all cameras that see `point`, through the recovered ones.
std::optional<Vec3> triangulated(const Rig& truth, const Rig& recovered, const Vec3& point) {
  Mat3 sum = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  int seen = 0;
  for (std::size_t c = 0; c < truth.cameras.size(); ++c) {
    const std::optional<Vec2> pixel = project(truth.cameras[c], point);
    if (!pixel) continue;
    const std::optional<Vec3> ray = rayThroughPixel(recovered.cameras[c].lens, *pixel);
    if (!ray) continue;
    const Pose world_from_camera = recovered.cameras[c].camera_from_world.inverse();
    const Vec3 along = world_from_camera.linear() * *ray;
    const Mat3 across = Mat3::Identity() - along * along.transpose();
    sum += across;
    right += across * world_from_camera.translation();
    ++seen;
  }
  if (seen < 2) return std::nullopt;
  return Vec3(sum.ldlt().solve(right));
}

double rmsAfterAlignment(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to, double* scale) {
  const Eigen::Matrix4d rigid = Eigen::umeyama(from, to, false);
  if (scale) *scale = std::cbrt(Eigen::umeyama(to, from, true).topLeftCorner<3, 3>().determinant());
  const Eigen::Matrix3Xd off =
      (rigid.topLeftCorner<3, 3>() * from).colwise() + rigid.topRightCorner<3, 1>() - to;
  return std::sqrt(off.squaredNorm() / static_cast<double>(off.cols()));
}

}  // namespace

Board a3Board() {
  Board board;
  board.squares_x = 7, board.squares_y = 5, board.square_m = 0.055, board.marker_m = 0.041;
  return board;
}

std::vector<Pose> wavedBoards(const Rig& rig, const Board& board, const Wave& wave) {
  std::mt19937 random(wave.seed);
  std::uniform_real_distribution<double> any(-1, 1);
  const Vec3 middle = 0.5 * board.square_m * Vec3(board.squares_x, board.squares_y, 0);
  std::vector<Pose> boards;
  for (int frame = 0; frame < wave.frames; ++frame) {
    // Towards the middle of two neighbouring cameras, where both see it; then tilted.
    const std::size_t first = static_cast<std::size_t>(frame) % rig.cameras.size();
    const Vec3 a = eyeOf(rig.cameras[first]), b = eyeOf(rig.cameras[(first + 1) % rig.cameras.size()]);
    const double share = 0.5 + 0.4 * any(random);
    const Vec3 towards = (share * a + (1 - share) * b).normalized() + Vec3(0, 0, 0.5 + 0.5 * any(random));
    Pose pose = Pose::Identity();
    const Vec3 tilt = 0.5 * Vec3(any(random), any(random), any(random));
    pose.linear() = rotationFromVector(tilt) * facing(-towards, 0.6 * any(random));
    const Vec3 place = rig.workspace.center + wave.reach_m * Vec3(any(random), any(random), any(random));
    pose.translation() = place - pose.linear() * middle;
    boards.push_back(pose);
  }
  return boards;
}

std::vector<CameraViews> seenCorners(const Rig& rig, const Board& board, const std::vector<Pose>& boards,
                                     const Wave& wave) {
  std::mt19937 random(wave.seed + 1000);
  std::normal_distribution<double> noise(0, wave.noise_px);
  std::uniform_real_distribution<double> any(0, 1);
  std::vector<CameraViews> cameras;
  for (const Camera& camera : rig.cameras) {
    CameraViews seen{camera.name, camera.width, camera.height, {}};
    for (std::size_t frame = 0; frame < boards.size(); ++frame) {
      const Pose& pose = boards[frame];
      const Vec3 to_eye = (eyeOf(camera) - pose * board.corner(0)).normalized();
      if (-pose.linear().col(2).dot(to_eye) < std::cos(70 * M_PI / 180))
        continue;  // no detector reads more tilt
      BoardView view;
      for (int id = 0; id < board.cornerCount(); ++id) {
        const std::optional<Vec2> pixel = project(camera, pose * board.corner(id));
        if (!pixel) continue;
        Vec2 found = *pixel + Vec2(noise(random), noise(random));
        if (any(random) < wave.outliers) {
          const double turn = 2 * M_PI * any(random);
          found += 10 * Vec2(std::cos(turn), std::sin(turn));
        }
        view.ids.push_back(id);
        view.pixels.push_back(found);
      }
      if (!view.ids.empty()) seen.views[static_cast<int>(frame)] = std::move(view);
    }
    cameras.push_back(std::move(seen));
  }
  return cameras;
}

CubeError cubeError(const Rig& truth, const Rig& recovered) {
  constexpr int kSteps = 12;
  std::vector<Vec3> from, to;
  std::vector<Vec3> central_from, central_to;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; ++j)
      for (int k = 0; k <= kSteps; ++k) {
        const Vec3 share = Vec3(i, j, k) / kSteps - Vec3::Constant(0.5);
        const Vec3 point = truth.workspace.center + truth.workspace.edge_m * share;
        const std::optional<Vec3> found = triangulated(truth, recovered, point);
        if (!found) continue;
        from.push_back(*found), to.push_back(point);
        if (share.cwiseAbs().maxCoeff() <= 0.25 + 1e-9)
          central_from.push_back(*found), central_to.push_back(point);
      }
  const auto matrix = [](const std::vector<Vec3>& points) {
    return Eigen::Matrix3Xd(
        Eigen::Map<const Eigen::Matrix3Xd>(points[0].data(), 3, static_cast<long>(points.size())));
  };
  CubeError error;
  error.central_mm = 1000 * rmsAfterAlignment(matrix(central_from), matrix(central_to), &error.scale);
  error.whole_mm = 1000 * rmsAfterAlignment(matrix(from), matrix(to), nullptr);
  return error;
}

}  // namespace airclay
