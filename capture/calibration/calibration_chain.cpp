// SPDX-License-Identifier: MIT
// Estimates the cameras' poses: for pairs from the boards that both see at the same time, then along the
// strongest chain of pairs.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/calibration/calibration_parts.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

// Two pair poses count as equal if a board's corners differ by less than this in the image: a flat board's
// pose is accurate to a few pixels; its mirrored solution is off by tens.
constexpr double kSamePose_px = 15;
// The number of a pair's shared boards that propose a pose; all of them vote.
constexpr std::size_t kMaxProposals = 60;

/// A board that both cameras of a pair see, with the two poses that each view allows.
struct SharedBoard {
  std::vector<Pose> a_from_board, b_from_board;
  std::array<Vec3, 4> outline;  // board
};

struct PairPose {
  Pose b_from_a = Pose::Identity();
  int agreeing = 0;  // shared boards that agree
};

std::array<Vec3, 4> outlineOf(const BundleView& view) {
  Vec3 low = view.corners[0], high = low;
  for (const Vec3& corner : view.corners) low = low.cwiseMin(corner), high = high.cwiseMax(corner);
  return {low, {high.x(), low.y(), 0}, high, {low.x(), high.y(), 0}};
}

/// The boards that cameras a and b see at the same time.
std::vector<SharedBoard> sharedBoards(const Bundle& bundle, const ViewPoses& poses, int a, int b) {
  std::map<int, std::size_t> seen_by_a;
  for (std::size_t i = 0; i < bundle.views.size(); ++i)
    if (bundle.views[i].camera == a && !poses[i].empty()) seen_by_a[bundle.views[i].stand] = i;
  std::vector<SharedBoard> shared;
  for (std::size_t i = 0; i < bundle.views.size(); ++i) {
    if (bundle.views[i].camera != b || poses[i].empty()) continue;
    const auto of_a = seen_by_a.find(bundle.views[i].stand);
    if (of_a != seen_by_a.end())
      shared.push_back({poses[of_a->second], poses[i], outlineOf(bundle.views[i])});
  }
  return shared;
}

/// The pair pose from one board that is closest to `b_from_a`, and the RMS difference of the board's outline
/// in b's image.
struct Nearest {
  Pose b_from_a = Pose::Identity();
  double apart_px = std::numeric_limits<double>::infinity();
};

Nearest nearestTo(const Pose& b_from_a, const SharedBoard& board, double focal_px) {
  Nearest nearest;
  for (const Pose& a_from_board : board.a_from_board)
    for (const Pose& b_from_board : board.b_from_board) {
      double sum = 0;
      for (const Vec3& corner : board.outline) {
        const Vec3 seen = b_from_board * corner, predicted = b_from_a * (a_from_board * corner);
        const Vec2 apart = seen.head<2>() / seen.z() - predicted.head<2>() / std::max(predicted.z(), 1e-3);
        sum += std::min(apart.squaredNorm(), 1.0) / 4;
      }
      const double apart_px = focal_px * std::sqrt(sum);
      if (apart_px < nearest.apart_px) nearest = {b_from_board * a_from_board.inverse(), apart_px};
    }
  return nearest;
}

/// The mean of poses: the average quaternion (Markley et al. 2007, "Averaging Quaternions") and the median of
/// each translation coordinate.
Pose meanOf(const std::vector<Pose>& poses) {
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  std::array<std::vector<double>, 3> translations;
  for (const Pose& pose : poses) {
    const Eigen::Vector4d q = Eigen::Quaterniond(pose.linear()).coeffs();
    sum += q * q.transpose();
    for (int i = 0; i < 3; ++i) translations[static_cast<std::size_t>(i)].push_back(pose.translation()[i]);
  }
  Pose mean = Pose::Identity();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(sum);
  mean.linear() = Eigen::Quaterniond(Eigen::Vector4d(solver.eigenvectors().col(3))).toRotationMatrix();
  for (int i = 0; i < 3; ++i) {
    std::vector<double>& values = translations[static_cast<std::size_t>(i)];
    std::sort(values.begin(), values.end());
    mean.translation()[i] = 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
  }
  return mean;
}

/// The mean of the poses on which most boards agree; mirrored solutions agree with none.
PairPose pairPose(const std::vector<SharedBoard>& boards, double focal_px) {
  Pose best = Pose::Identity();
  double least = std::numeric_limits<double>::infinity();
  const std::size_t step = (boards.size() + kMaxProposals - 1) / kMaxProposals;
  for (std::size_t i = 0; i < boards.size(); i += step)
    for (const Pose& a_from_board : boards[i].a_from_board)
      for (const Pose& b_from_board : boards[i].b_from_board) {
        const Pose proposed = b_from_board * a_from_board.inverse();
        double cost = 0;
        for (const SharedBoard& board : boards)
          cost += std::min(nearestTo(proposed, board, focal_px).apart_px, kSamePose_px);
        if (cost < least) best = proposed, least = cost;
      }
  for (int round = 0; round < 2; ++round) {
    std::vector<Pose> agreeing;
    for (const SharedBoard& board : boards)
      if (const Nearest nearest = nearestTo(best, board, focal_px); nearest.apart_px < kSamePose_px)
        agreeing.push_back(nearest.b_from_a);
    if (agreeing.empty()) break;
    best = meanOf(agreeing);
    if (round == 1) return {best, static_cast<int>(agreeing.size())};
  }
  return {best, boards.empty() ? 0 : 1};
}

[[noreturn]] void failUnconnected(const std::vector<CameraViews>& cameras, const std::vector<char>& placed) {
  std::string here, there;
  for (std::size_t i = 0; i < cameras.size(); ++i)
    (placed[i] ? here : there) +=
        ((placed[i] ? here : there).empty() ? "\"" : ", \"") + cameras[i].name + "\"";
  throw Error("in no frame is the board visible to one of the cameras " + here + " and one of " + there +
              "; wave it where two of them see it at the same time, for at least 20 frames");
}

}  // namespace

void chainCameras(Bundle& bundle, const ViewPoses& poses, const std::vector<CameraViews>& cameras) {
  const std::size_t count = bundle.cameras.size();
  std::vector<std::vector<PairPose>> pairs(count, std::vector<PairPose>(count));
  for (std::size_t a = 0; a < count; ++a)
    for (std::size_t b = a + 1; b < count; ++b) {
      const PairPose pair = pairPose(sharedBoards(bundle, poses, static_cast<int>(a), static_cast<int>(b)),
                                     bundle.cameras[b].lens.fx);
      pairs[a][b] = pair;
      pairs[b][a] = {pair.b_from_a.inverse(), pair.agreeing};
    }
  // The maximum spanning tree (Prim 1957) of the pairs, weighted by the number of boards that agree.
  std::vector<char> placed(count, 0);
  placed[0] = 1;
  for (std::size_t done = 1; done < count; ++done) {
    std::size_t from = 0, to = 0;
    int most = 0;
    for (std::size_t a = 0; a < count; ++a)
      for (std::size_t b = 0; b < count; ++b)
        if (placed[a] && !placed[b] && pairs[a][b].agreeing > most)
          from = a, to = b, most = pairs[a][b].agreeing;
    if (most == 0) failUnconnected(cameras, placed);
    bundle.cameras[to].camera_from_world = pairs[from][to].b_from_a * bundle.cameras[from].camera_from_world;
    placed[to] = 1;
  }
}

}  // namespace airclay
