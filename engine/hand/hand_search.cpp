// SPDX-License-Identifier: MIT
#include "engine/hand/hand_search.h"

#include <algorithm>
#include <cmath>
#include <queue>

#include "engine/hand/fit.h"
#include "shaders/hand/search_hull.comp.h"
#include "shaders/hand/search_score.comp.h"
#include "shaders/hand/search_shrink.comp.h"

namespace airclay {
namespace {

// The hand's centre of mass is this far from the end of the part that contains it, along its long axis.
constexpr std::array kFromEnd_m = {0.07, 0.09, 0.12};
constexpr double kSlab_m = 0.02;  // the part's centre is taken over this distance either way
// The direction of the hand is that between its parts at these distances from the end.
constexpr double kFingersFromEnd_m = 0.05, kWristFromEnd_m = 0.15;
constexpr double kSameEnd_m = 0.06;
constexpr double kTilt_rad = 0.5;
constexpr int kTilts = 6, kRolls = 12;
constexpr std::size_t kMaxPoses = 3 * kFromEnd_m.size() * (1 + kTilts) * kRolls;
constexpr std::size_t kSubmission = 126;  // poses: short submissions, so that a window can draw in between
constexpr double kSameRotation_rad = 0.4;
// A hull is larger than its hand, but a coarse one of uncertain pixels loses thin fingers.
constexpr double kLeastVolume = 0.25;
constexpr double kNotSeen = 1e3;

std::vector<std::uint32_t> imageConstants(const GpuRig& rig, std::uint32_t workgroup) {
  const auto [width, height] = rig.sameSize();
  return {workgroup, width, height, rig.lensKinds()};
}

constexpr int kGrid = kHullVoxels;

/// Calls `visit` for the up to 26 neighbours of a voxel, with the distance in voxels.
template <class Visit>
void forEachNeighbour(int voxel, Visit visit) {
  const int x = voxel % kGrid, y = voxel / kGrid % kGrid, z = voxel / (kGrid * kGrid);
  for (int d = 0; d < 27; ++d) {
    const int dx = d % 3 - 1, dy = d / 3 % 3 - 1, dz = d / 9 - 1;
    if (d == 13 || std::min({x + dx, y + dy, z + dz}) < 0 || std::max({x + dx, y + dy, z + dz}) >= kGrid)
      continue;
    visit(voxel + dx + kGrid * (dy + kGrid * dz), std::sqrt(dx * dx + dy * dy + dz * dz));
  }
}

/// The length of the shortest way through the part from the nearest of `from` to each of its voxels, metres.
std::vector<double> distancesFrom(const std::vector<int>& part, const std::vector<int>& from,
                                  double voxel_m) {
  constexpr double kFar = 1e9;
  std::vector<double> all(std::size_t(kGrid) * kGrid * kGrid, -1);  // -1: not of the part
  for (const int voxel : part) all[std::size_t(voxel)] = kFar;
  using Way = std::pair<double, int>;
  std::priority_queue<Way, std::vector<Way>, std::greater<>> ways;
  for (const int voxel : from) {
    all[std::size_t(voxel)] = 0;
    ways.emplace(0, voxel);
  }
  while (!ways.empty()) {
    const auto [length, voxel] = ways.top();
    ways.pop();
    if (length > all[std::size_t(voxel)]) continue;
    forEachNeighbour(voxel, [&](int neighbour, double step) {
      double& known = all[std::size_t(neighbour)];
      if (length + step * voxel_m >= known) return;
      known = length + step * voxel_m;
      ways.emplace(known, neighbour);
    });
  }
  std::vector<double> distances;
  for (const int voxel : part) distances.push_back(all[std::size_t(voxel)]);
  return distances;
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

std::vector<int> HandSearch::largestPart() const {
  std::vector<char> rest(kGrid * kGrid * kGrid);
  const std::span<const std::uint32_t> words = hull_.host();
  for (std::size_t i = 0; i < rest.size(); ++i) rest[i] = (words[i / kHullRun] >> (i % kHullRun) & 1) != 0;
  std::vector<int> largest;
  for (std::size_t start = 0; start < rest.size(); ++start) {
    if (!rest[start]) continue;
    std::vector<int> part{static_cast<int>(start)};
    rest[start] = 0;
    for (std::size_t next = 0; next < part.size(); ++next)
      forEachNeighbour(part[next], [&](int neighbour, double) {
        if (!rest[std::size_t(neighbour)]) return;
        rest[std::size_t(neighbour)] = 0;
        part.push_back(neighbour);
      });
    if (part.size() > largest.size()) largest = std::move(part);
  }
  return largest.size() < least_voxels_ ? std::vector<int>{} : largest;
}

std::vector<ScoredPose> HandSearch::hypotheses(const std::vector<int>& part, double scale) const {
  const double voxel_m = rig_.rig().workspace.edge_m / kGrid;
  const auto center = [&](int voxel) {
    return Vec3(voxel_m * (Vec3(voxel % kGrid, voxel / kGrid % kGrid, voxel / (kGrid * kGrid)) +
                           Vec3::Constant(0.5 - 0.5 * kGrid)));
  };
  // The hand is at an end of the part: the one farthest from where the arm enters the workspace, or, for a
  // part inside it, at one of the two ends that are farthest from each other.
  std::vector<int> entrance;
  for (const int voxel : part) {
    const auto [low, high] = std::minmax({voxel % kGrid, voxel / kGrid % kGrid, voxel / (kGrid * kGrid)});
    if (low == 0 || high == kGrid - 1) entrance.push_back(voxel);
  }
  std::vector<int> ends;
  std::vector<std::vector<double>> distances;  // of the part's voxels from each end, through the part
  const auto addEnd = [&](const std::vector<int>& from) {
    const std::vector<double> away = distancesFrom(part, from, voxel_m);
    const int end = part[std::size_t(std::ranges::max_element(away) - away.begin())];
    for (const int other : ends)
      if ((center(other) - center(end)).norm() < kSameEnd_m) return;
    ends.push_back(end);
    distances.push_back(distancesFrom(part, {end}, voxel_m));
  };
  if (!entrance.empty()) addEnd(entrance);
  addEnd({part.front()});
  addEnd({ends.back()});

  std::vector<ScoredPose> poses;
  for (std::size_t e = 0; e < ends.size(); ++e) {
    const auto slab = [&](double from_end) {
      Vec3 sum = Vec3::Zero();
      int count = 0;
      for (std::size_t i = 0; i < part.size(); ++i)
        if (std::abs(distances[e][i] - from_end) < kSlab_m) {
          sum += center(part[i]);
          ++count;
        }
      return count > 0 ? Vec3(sum / count) : center(ends[e]);
    };
    const Vec3 along = slab(scale * kWristFromEnd_m) - slab(scale * kFingersFromEnd_m);
    if (along.norm() < kSlab_m / 2) continue;  // too small for a hand
    const Vec3 to_forearm = along.normalized();
    const Vec3 side = to_forearm.unitOrthogonal(), up = to_forearm.cross(side);
    for (const double from_end : kFromEnd_m) {
      const Vec3 position = slab(scale * from_end);
      for (int tilt = 0; tilt <= kTilts; ++tilt) {
        Vec3 direction = to_forearm;
        if (tilt > 0) {
          const double angle = (tilt - 1) * 2 * M_PI / kTilts;
          direction = std::cos(kTilt_rad) * to_forearm +
                      std::sin(kTilt_rad) * (std::cos(angle) * side + std::sin(angle) * up);
        }
        const Mat3 turn = Eigen::Quaterniond::FromTwoVectors(model_.to_forearm, direction).toRotationMatrix();
        for (int roll = 0; roll < kRolls; ++roll)
          poses.push_back({outlinePose(rotationFromVector(direction * (roll * 2 * M_PI / kRolls)) * turn,
                                       position, scale),
                           static_cast<int>(e), 0});
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
                                               const GpuOutlineFrame& frame, double scale,
                                               std::size_t per_end, StageTimes& stage_ms) {
  const std::uint32_t cameras = rig_.cameraCount();
  recorder.begin();
  recorder.stage("carve");
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

  const std::vector<int> part = largestPart();
  if (part.empty()) return {};
  std::vector<ScoredPose> all = hypotheses(part, scale);
  std::vector<GpuOutlinePose> poses;
  for (const ScoredPose& hypothesis : all) poses.push_back(hypothesis.pose);
  const std::vector<double> score = scores(recorder, frame, poses, stage_ms);
  for (std::size_t i = 0; i < all.size(); ++i) all[i].score = score[i];
  std::ranges::stable_sort(all, {}, &ScoredPose::score);
  std::vector<ScoredPose> best;
  for (const ScoredPose& candidate : all) {
    const auto sameEnd = [&](const ScoredPose& other) { return other.end == candidate.end; };
    const bool is_old = std::ranges::any_of(best, [&](const ScoredPose& other) {
      return sameEnd(other) &&
             angleBetween(rotationOf(other.pose), rotationOf(candidate.pose)) < kSameRotation_rad;
    });
    if (!is_old && std::size_t(std::ranges::count_if(best, sameEnd)) < per_end) best.push_back(candidate);
  }
  return best;
}

}  // namespace airclay
