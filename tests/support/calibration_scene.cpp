// SPDX-License-Identifier: MIT
#include "tests/support/calibration_scene.h"

#include <Eigen/SVD>
#include <cmath>
#include <functional>
#include <future>
#include <opencv2/imgcodecs.hpp>

#include "capture/images/video_writer.h"
#include "tests/support/board_scene.h"

namespace airclay {
namespace {

Vec3 eyeOf(const Camera& camera) {
  return camera.camera_from_world.inverse().translation();
}

/// A right-handed frame with z = `forward`.
Mat3 facing(const Vec3& forward, double roll) {
  const Vec3 z = forward.normalized();
  const Vec3 x =
      (z.cross(Vec3::UnitZ()).norm() > 0.05 ? z.cross(Vec3::UnitZ()) : z.cross(Vec3::UnitX())).normalized();
  Mat3 frame;
  frame << x, z.cross(x), z;
  return frame * Eigen::AngleAxisd(roll, Vec3::UnitZ()).toRotationMatrix();
}

/// The point nearest to the recovered rays of all cameras that see `point`.
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

/// Renders in parallel, because it is slow.
void forEachCamera(const Rig& rig, const std::function<void(const Camera&)>& draw) {
  std::vector<std::future<void>> drawn;
  for (const Camera& camera : rig.cameras)
    drawn.push_back(std::async(std::launch::async, [&draw, &camera] { draw(camera); }));
  for (std::future<void>& one : drawn) one.get();
}

std::vector<std::uint8_t> imageOf(const Board& board, const Camera& camera, const std::vector<Pose>& boards,
                                  std::size_t frame) {
  BoardShot shot;
  shot.noise_sigma = 2;
  shot.seed = static_cast<std::uint32_t>(frame + 1);
  return drawBoard(board, camera, boards[frame], shot);
}

/// Points of the true rig's workspace: as the recovered rig finds them, and their true positions.
struct CubePoints {
  std::vector<Vec3> found, true_ones;

  Eigen::Matrix3Xd foundMatrix() const { return matrix(found); }
  Eigen::Matrix3Xd trueMatrix() const { return matrix(true_ones); }

 private:
  static Eigen::Matrix3Xd matrix(const std::vector<Vec3>& points) {
    return Eigen::Map<const Eigen::Matrix3Xd>(points[0].data(), 3, static_cast<long>(points.size()));
  }
};

/// The points in the central `fraction` of the workspace's edge.
CubePoints cubePoints(const Rig& truth, const Rig& recovered, double fraction) {
  constexpr int kSteps = 12;
  CubePoints points;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; ++j)
      for (int k = 0; k <= kSteps; ++k) {
        const Vec3 from_middle = Vec3(i, j, k) / kSteps - Vec3::Constant(0.5);
        if (from_middle.cwiseAbs().maxCoeff() > fraction / 2 + 1e-9) continue;
        const Vec3 point = truth.workspace.center + truth.workspace.edge_m * from_middle;
        const std::optional<Vec3> found = triangulated(truth, recovered, point);
        if (found) points.found.push_back(*found), points.true_ones.push_back(point);
      }
  return points;
}

/// true_from_found, the least-squares rigid transform (Umeyama 1991).
Pose alignment(const CubePoints& points) {
  Pose pose;
  pose.matrix() = Eigen::umeyama(points.foundMatrix(), points.trueMatrix(), false);
  return pose;
}

double rmsMm(const CubePoints& points, const Pose& true_from_found) {
  const Eigen::Matrix3Xd off =
      ((true_from_found.linear() * points.foundMatrix()).colwise() + true_from_found.translation()) -
      points.trueMatrix();
  return 1000 * std::sqrt(off.squaredNorm() / static_cast<double>(off.cols()));
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
    // Towards the middle of two neighbouring cameras, so that both see it; then tilted.
    const std::size_t first = static_cast<std::size_t>(frame) % rig.cameras.size();
    const Vec3 a = eyeOf(rig.cameras[first]), b = eyeOf(rig.cameras[(first + 1) % rig.cameras.size()]);
    const double fraction = 0.5 + 0.4 * any(random);
    const Vec3 towards =
        (fraction * a + (1 - fraction) * b).normalized() + Vec3(0, 0, 0.5 + 0.5 * any(random));
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

void drawImages(const std::filesystem::path& folder, const Rig& rig, const Board& board,
                const std::vector<Pose>& boards) {
  forEachCamera(rig, [&](const Camera& camera) {
    std::filesystem::create_directories(folder / camera.name);
    for (std::size_t frame = 0; frame < boards.size(); ++frame) {
      std::vector<std::uint8_t> bgr = imageOf(board, camera, boards, frame);
      const cv::Mat image(camera.height, camera.width, CV_8UC3, bgr.data());
      cv::imwrite((folder / camera.name / (std::to_string(frame) + ".png")).string(), image);
    }
  });
}

void drawVideos(const std::filesystem::path& folder, const Rig& rig, const Board& board,
                const std::vector<Pose>& boards) {
  forEachCamera(rig, [&](const Camera& camera) {
    VideoWriter video(folder / (camera.name + ".mp4"),
                      {.size = {camera.width, camera.height}, .format = VideoWriter::Format::kBgr8});
    for (std::size_t frame = 0; frame < boards.size(); ++frame)
      video.write(imageOf(board, camera, boards, frame));
    video.finish();
  });
}

CubeError cubeError(const Rig& truth, const Rig& recovered) {
  const CubePoints central = cubePoints(truth, recovered, 0.5), whole = cubePoints(truth, recovered, 1);
  CubeError error;
  error.central_mm = rmsMm(central, alignment(central));
  error.whole_mm = rmsMm(whole, alignment(whole));
  const Eigen::Matrix4d similar = Eigen::umeyama(central.trueMatrix(), central.foundMatrix(), true);
  error.scale = std::cbrt(similar.topLeftCorner<3, 3>().determinant());
  return error;
}

CubeError cubeErrorInPlace(const Rig& truth, const Rig& recovered) {
  CubeError error = cubeError(truth, recovered);
  error.central_mm = rmsMm(cubePoints(truth, recovered, 0.5), Pose::Identity());
  error.whole_mm = rmsMm(cubePoints(truth, recovered, 1), Pose::Identity());
  return error;
}

Rig alignedTo(const Rig& truth, const Rig& recovered) {
  const Pose recovered_from_true = alignment(cubePoints(truth, recovered, 1)).inverse();
  Rig aligned = recovered;
  for (Camera& camera : aligned.cameras)
    camera.camera_from_world = camera.camera_from_world * recovered_from_true;
  aligned.workspace = truth.workspace;
  return aligned;
}

Camera bumped(Camera camera, const Vec3& by_m, const Vec3& turn) {
  Pose old_from_new = Pose::Identity();  // of the camera's own frame
  old_from_new.linear() = rotationFromVector(turn);
  old_from_new.translation() = by_m;
  camera.camera_from_world = old_from_new.inverse() * camera.camera_from_world;
  return camera;
}

}  // namespace airclay
