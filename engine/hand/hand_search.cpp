// SPDX-License-Identifier: MIT
#include "engine/hand/hand_search.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "engine/hand/fit.h"
#include "shaders/hand/search_hull.comp.h"
#include "shaders/hand/search_score.comp.h"
#include "shaders/hand/search_shrink.comp.h"

namespace airclay {
namespace {

// The hand's centre of mass is this far from the end of the part that contains it, along its long axis.
constexpr std::array kFromEnd_m = {0.07, 0.09, 0.12};
constexpr double kSlab_m = 0.02;  // the part's centre is taken over this distance either way
constexpr double kTilt_rad = 0.5;
constexpr int kTilts = 6, kRolls = 12;
constexpr std::size_t kMaxPoses = 2 * kFromEnd_m.size() * (1 + kTilts) * kRolls;
constexpr std::size_t kSubmission = 126;  // poses: short submissions, so that a window can draw in between
constexpr double kSameRotation_rad = 0.4;
// A hull is larger than its hand, but a coarse one of uncertain pixels loses thin fingers.
constexpr double kLeastVolume = 0.25;
constexpr double kNotSeen = 1e3;

std::vector<std::uint32_t> imageConstants(const GpuRig& rig, std::uint32_t workgroup) {
  const auto [width, height] = rig.sameSize();
  return {workgroup, width, height, rig.lensKinds()};
}

}  // namespace

HandSearch::HandSearch(Gpu& gpu, const GpuRig& rig, const OutlineModel& model)
    : rig_(rig),
      model_(model),
      shrink_(gpu, "search_shrink", search_shrink_comp, imageConstants(rig, kOutlineWorkgroup)),
      hull_kernel_(gpu, "search_hull", search_hull_comp, imageConstants(rig, kOutlineWorkgroup)),
      score_(gpu, "search_score", search_score_comp,
             imageConstants(rig, gpu.isCpu() ? gpu.subgroupSize() : kOutlineWorkgroup)),
      blocks_(gpu, rig.pixels() / 64),
      hull_(gpu, kHullVoxels * kHullVoxels * kHullVoxels / kHullRun, Memory::kHost),
      points_(gpu, model.points),
      frame_(gpu, 1, Memory::kHost),
      poses_(gpu, kMaxPoses, Memory::kHost),
      scores_(gpu, kMaxPoses * rig.cameraCount(), Memory::kHost) {
  double volume_m3 = 0;
  for (const GpuTriangle& triangle : model.triangles) {
    const auto corner = [&](int k) { return Vec3(model.vertices[triangle.corners[k]].cast<double>()); };
    volume_m3 += corner(0).dot(corner(1).cross(corner(2))) / 6;
  }
  const double voxel_m = rig.rig().workspace.edge_m / kHullVoxels;
  least_voxels_ = static_cast<std::size_t>(std::max(1.0, kLeastVolume * volume_m3 / std::pow(voxel_m, 3)));
}

std::vector<Vec3> HandSearch::largestPart() const {
  constexpr int n = kHullVoxels;
  const std::span<const std::uint32_t> words = hull_.host();
  std::vector<char> rest(std::size_t(n) * n * n);
  for (std::size_t i = 0; i < rest.size(); ++i) rest[i] = (words[i / kHullRun] >> (i % kHullRun) & 1) != 0;
  std::vector<int> largest;
  for (int start = 0; start < n * n * n; ++start) {
    if (!rest[std::size_t(start)]) continue;
    std::vector<int> part{start};
    rest[std::size_t(start)] = 0;
    for (std::size_t next = 0; next < part.size(); ++next) {
      const std::array at = {part[next] % n, part[next] / n % n, part[next] / (n * n)};
      for (int d = 0; d < 27; ++d) {
        const int x = at[0] + d % 3 - 1, y = at[1] + d / 3 % 3 - 1, z = at[2] + d / 9 - 1;
        if (std::min({x, y, z}) < 0 || std::max({x, y, z}) >= n) continue;
        const int neighbour = x + n * (y + n * z);
        if (!rest[std::size_t(neighbour)]) continue;
        rest[std::size_t(neighbour)] = 0;
        part.push_back(neighbour);
      }
    }
    if (part.size() > largest.size()) largest = std::move(part);
  }
  std::vector<Vec3> points;
  if (largest.size() < least_voxels_) return points;
  const double voxel_m = rig_.rig().workspace.edge_m / n;
  for (const int i : largest)
    points.push_back(voxel_m * (Vec3(i % n, i / n % n, i / (n * n)) + Vec3::Constant(0.5 - 0.5 * n)));
  return points;
}

std::vector<GpuOutlinePose> HandSearch::hypotheses(const std::vector<Vec3>& part, double scale) const {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& point : part) mean += point / double(part.size());
  Mat3 spread = Mat3::Zero();
  for (const Vec3& point : part) spread += (point - mean) * (point - mean).transpose();
  const Vec3 axis = Eigen::SelfAdjointEigenSolver<Mat3>(spread).eigenvectors().col(2);
  std::vector<GpuOutlinePose> poses;
  for (const double sign : {1.0, -1.0}) {
    std::vector<double> places;
    for (const Vec3& point : part) places.push_back(sign * (point - mean).dot(axis));
    std::vector<double> sorted = places;
    std::ranges::sort(sorted);
    const double end = sorted[static_cast<std::size_t>(0.995 * double(sorted.size() - 1))];
    for (const double from_end : kFromEnd_m) {
      const double place = end - scale * from_end;
      Vec3 center = Vec3::Zero();
      int count = 0;
      for (std::size_t i = 0; i < part.size(); ++i)
        if (std::abs(places[i] - place) < kSlab_m) {
          center += part[i];
          ++count;
        }
      center = count > 0 ? Vec3(center / count) : Vec3(mean + sign * place * axis);
      const Vec3 to_forearm = -sign * axis;
      const Vec3 side = to_forearm.unitOrthogonal(), up = to_forearm.cross(side);
      for (int tilt = 0; tilt <= kTilts; ++tilt) {
        Vec3 direction = to_forearm;
        if (tilt > 0) {
          const double angle = (tilt - 1) * 2 * M_PI / kTilts;
          direction = std::cos(kTilt_rad) * to_forearm +
                      std::sin(kTilt_rad) * (std::cos(angle) * side + std::sin(angle) * up);
        }
        const Mat3 turn = Eigen::Quaterniond::FromTwoVectors(model_.to_forearm, direction).toRotationMatrix();
        for (int roll = 0; roll < kRolls; ++roll)
          poses.push_back(outlinePose(rotationFromVector(direction * (roll * 2 * M_PI / kRolls)) * turn, center, scale));
      }
    }
  }
  return poses;
}

std::vector<double> HandSearch::scores(Recorder& recorder, const GpuOutlineFrame& frame,
                                       std::span<const GpuOutlinePose> poses, StageTimes& stage_ms) {
  frame_.host()[0] = frame;
  const std::uint32_t cameras = rig_.cameraCount();
  std::vector<double> result;
  for (std::size_t first = 0; first < poses.size(); first += kSubmission) {
    const std::size_t count = std::min(kSubmission, poses.size() - first);
    std::copy_n(poses.begin() + std::ptrdiff_t(first), count, poses_.host().begin());
    SearchScoreArgs args{};
    args.cameras = rig_.cameras();
    args.frame = frame_;
    args.poses = poses_;
    args.points = points_;
    args.blocks = blocks_;
    args.scores = scores_;
    args.point_count = static_cast<std::uint32_t>(points_.count());
    args.camera_count = cameras;
    recorder.begin();
    recorder.stage("fit");
    recorder.dispatch(score_, args, static_cast<std::uint32_t>(count), cameras);
    recorder.submitAndWait();
    addStages(recorder.stageMs(), stage_ms);
    for (std::size_t i = 0; i < count; ++i) {
      double sum = 0;
      int seen = 0;
      for (std::uint32_t camera = 0; camera < cameras; ++camera) {
        const double score = scores_.host()[i * cameras + camera];
        if ((frame.cameras >> camera & 1) == 0 || score < 0) continue;
        sum += score;
        ++seen;
      }
      result.push_back(seen >= 2 ? sum / seen : kNotSeen);
    }
  }
  return result;
}

std::vector<ScoredPose> HandSearch::candidates(Recorder& recorder, const Evidence& evidence,
                                               const GpuOutlineFrame& frame, double scale, std::size_t count,
                                               StageTimes& stage_ms) {
  const std::uint32_t cameras = rig_.cameraCount();
  recorder.begin();
  recorder.stage("fit");
  SearchShrinkArgs shrink{};
  shrink.cameras = rig_.cameras();
  shrink.evidence = evidence.evidence();
  shrink.blocks = blocks_;
  recorder.dispatch(shrink_, shrink, groupsFor(rig_.maxPixels() / 64, kOutlineWorkgroup), cameras);
  SearchHullArgs hull{};
  hull.cameras = rig_.cameras();
  hull.blocks = blocks_;
  hull.words = hull_;
  hull.camera_count = cameras;
  hull.camera_bits = frame.cameras;
  hull.voxel_m = static_cast<float>(rig_.rig().workspace.edge_m / kHullVoxels);
  recorder.dispatch(hull_kernel_, hull, groupsFor(hull_.count(), kOutlineWorkgroup));
  recorder.submitAndWait();
  addStages(recorder.stageMs(), stage_ms);

  const std::vector<Vec3> part = largestPart();
  if (part.empty()) return {};
  const std::vector<GpuOutlinePose> poses = hypotheses(part, scale);
  const std::vector<double> score = scores(recorder, frame, poses, stage_ms);
  std::vector<ScoredPose> sorted;
  for (std::size_t i = 0; i < poses.size(); ++i) sorted.push_back({poses[i], score[i]});
  std::ranges::stable_sort(sorted, {}, &ScoredPose::score);
  std::vector<ScoredPose> best;
  for (const ScoredPose& candidate : sorted) {
    const bool is_new = std::ranges::none_of(best, [&](const ScoredPose& other) {
      return angleBetween(rotationOf(other.pose), rotationOf(candidate.pose)) < kSameRotation_rad;
    });
    if (is_new) best.push_back(candidate);
    if (best.size() == count) break;
  }
  return best;
}

}  // namespace airclay
