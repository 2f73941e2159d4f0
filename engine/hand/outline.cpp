// SPDX-License-Identifier: MIT
#include "engine/hand/outline.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "engine/core/error.h"
#include "shaders/hand/outline_coarse.comp.h"
#include "shaders/hand/outline_fine.comp.h"
#include "shaders/hand/outline_list.comp.h"
#include "shaders/hand/outline_mask.comp.h"
#include "shaders/hand/outline_project.comp.h"
#include "shaders/hand/outline_solve.comp.h"

namespace airclay {
namespace {

// The forearm begins inside the hand, so that the wrist's edges, which sleeves cover, do not count.
constexpr double kArmOverlap_m = 0.02, kArmLength_m = 0.35, kArmRadius_m = 0.045;
constexpr double kSamePlace_m = 1e-6;

std::vector<std::uint32_t> imageConstants(const GpuRig& rig) {
  const auto [width, height] = rig.sameSize();
  return {kOutlineWorkgroup, width, height, rig.lensKinds()};
}

Vec3 restPosition(const HandModel& hand, const std::string& joint) {
  const auto found = std::ranges::find(hand.joints, joint, &Joint::name);
  if (found == hand.joints.end()) throw Error("the hand model lacks the joint " + joint);
  return found->hand_from_joint_rest.translation();
}

/// The closed skin with vertices at the same place joined.
TriangleMesh joined(const TriangleMesh& skin) {
  TriangleMesh mesh;
  std::map<std::array<std::int64_t, 3>, int> places;
  std::vector<int> joined_index;
  for (const Vec3& vertex : skin.vertices) {
    std::array<std::int64_t, 3> place;
    for (int k = 0; k < 3; ++k) place[std::size_t(k)] = std::llround(vertex[k] / kSamePlace_m);
    const auto [found, is_new] = places.try_emplace(place, static_cast<int>(mesh.vertices.size()));
    if (is_new) mesh.vertices.push_back(vertex);
    joined_index.push_back(found->second);
  }
  for (const auto& [a, b, c] : skin.triangles)
    mesh.triangles.push_back(
        {joined_index[std::size_t(a)], joined_index[std::size_t(b)], joined_index[std::size_t(c)]});
  return mesh;
}

/// Edges with exactly two triangles, neither of them at the cut.
std::vector<GpuOutlineEdge> skinEdges(const TriangleMesh& mesh, const std::vector<char>& is_cut) {
  struct Side {
    int from = 0, to = 0, opposite = 0, count = 0;
    bool cut = false;
  };
  std::map<std::pair<int, int>, std::array<Side, 2>> sides;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const int from = mesh.triangles[t][k], to = mesh.triangles[t][(k + 1) % 3];
      const int opposite = mesh.triangles[t][(k + 2) % 3];
      if (from == to || to == opposite || from == opposite) continue;
      Side& side = sides[std::minmax(from, to)][from < to ? 0 : 1];
      side = {from, to, opposite, side.count + 1, side.cut || is_cut[t] != 0};
    }
  std::vector<GpuOutlineEdge> edges;
  for (const auto& [ends, both] : sides) {
    if (both[0].count != 1 || both[1].count != 1 || both[0].cut || both[1].cut) continue;
    edges.push_back({std::uint32_t(both[0].from), std::uint32_t(both[0].to), std::uint32_t(both[0].opposite),
                     std::uint32_t(both[1].opposite)});
  }
  return edges;
}

/// Leaves out points closer than this to another one.
std::vector<Vec3> thinned(const std::vector<Vec3>& points, double distance_m) {
  using Place = std::array<int, 3>;
  const auto placeOf = [&](const Vec3& point) {
    const Eigen::Vector3i place = (point / distance_m).array().floor().cast<int>();
    return Place{place.x(), place.y(), place.z()};
  };
  std::map<Place, std::vector<Vec3>> kept_at;
  std::vector<Vec3> kept;
  for (const Vec3& point : points) {
    const Place place = placeOf(point);
    bool is_new = true;
    for (int k = 0; k < 27 && is_new; ++k)
      if (const auto near =
              kept_at.find({place[0] + k % 3 - 1, place[1] + k / 3 % 3 - 1, place[2] + k / 9 - 1});
          near != kept_at.end())
        is_new = std::ranges::none_of(near->second,
                                      [&](const Vec3& other) { return (other - point).norm() < distance_m; });
    if (!is_new) continue;
    kept_at[place].push_back(point);
    kept.push_back(point);
  }
  return kept;
}

/// Points on the skin; no place is farther than the spacing from one.
std::vector<Vec3> skinPoints(const TriangleMesh& mesh, double spacing_m) {
  std::vector<Vec3> points = mesh.vertices;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 &p = mesh.vertices[std::size_t(a)], &q = mesh.vertices[std::size_t(b)],
               &r = mesh.vertices[std::size_t(c)];
    const double longest = std::max({(q - p).norm(), (r - q).norm(), (p - r).norm()});
    const int n = static_cast<int>(std::ceil(longest / spacing_m));
    for (int i = 0; i <= n && n > 1; ++i)
      for (int j = 0; i + j <= n; ++j) {
        if (std::max({i, j, n - i - j}) == n) continue;  // a corner
        points.push_back((i * p + j * q + (n - i - j) * r) / n);
      }
  }
  return points;
}

}  // namespace

OutlineModel outlineModel(const HandModel& hand) {
  const TriangleMesh mesh = joined(withCaps(hand.skin));
  std::vector<char> is_cut = hand.cut_patches;
  is_cut.resize(mesh.triangles.size(), 1);  // withCaps() closes the skin where the forearm continues
  OutlineModel model;
  model.center_of_mass = massProperties(hand.skin).centroid;
  const auto relative = [&](const Vec3& point) { return vec3((point - model.center_of_mass).cast<float>()); };
  for (const Vec3& vertex : mesh.vertices) {
    model.vertices.push_back(relative(vertex));
    model.radius_m = std::max(model.radius_m, (vertex - model.center_of_mass).norm());
  }
  for (const auto& [a, b, c] : mesh.triangles)
    model.triangles.push_back({{std::uint32_t(a), std::uint32_t(b), std::uint32_t(c)}});
  model.edges = skinEdges(mesh, is_cut);
  for (const Vec3& point :
       thinned(skinPoints(mesh, OutlineModel::kPointSpacing_m), OutlineModel::kPointSpacing_m))
    model.points.push_back(relative(point));
  const Vec3 wrist = restPosition(hand, "wrist") - model.center_of_mass;
  const Vec3 knuckle = restPosition(hand, "middle-finger-phalanx-proximal") - model.center_of_mass;
  model.to_forearm = (wrist - knuckle).normalized();
  model.arm_from = wrist - kArmOverlap_m * model.to_forearm;
  model.arm_to = wrist + kArmLength_m * model.to_forearm;
  return model;
}

OutlineFitter::OutlineFitter(Gpu& gpu, const GpuRig& rig, const OutlineModel& model)
    : rig_(rig),
      model_(model),
      project_(gpu, "outline_project", outline_project_comp,
               {kOutlineWorkgroup, rig.lensKinds(), std::min(gpu.subgroupSize(), 8u)}),
      mask_(gpu, "outline_mask", outline_mask_comp, imageConstants(rig)),
      list_(gpu, "outline_list", outline_list_comp, {gpu.subgroupSize()}),
      coarse_(gpu, "outline_coarse", outline_coarse_comp, imageConstants(rig)),
      fine_(gpu, "outline_fine", outline_fine_comp, imageConstants(rig)),
      solve_(gpu, "outline_solve", outline_solve_comp, {gpu.reductionWorkgroup()}),
      vertices_(gpu, model.vertices),
      triangles_(gpu, model.triangles),
      edges_(gpu, model.edges),
      frame_(gpu, 1, Memory::kHost),
      pose_(gpu, 1, Memory::kHost),
      pixels_(gpu, model.vertices.size() * rig.cameraCount()),
      forearms_(gpu, std::size_t(2) * rig.cameraCount(), Memory::kHost),
      masks_(gpu, rig.maskWords()),
      lists_(gpu, std::size_t(kOutlineList) * rig.cameraCount()),
      lines_(gpu, std::size_t(kOutlineLines) * rig.cameraCount()),
      result_(gpu, 1, Memory::kHost) {}

GpuOutlineFrame OutlineFitter::frame() const {
  GpuOutlineFrame frame{};
  frame.velocity.setZero();
  frame.spin.setZero();
  frame.arm_radius = kArmRadius_m;
  frame.arm_from = model_.arm_from.cast<float>();
  frame.arm_to = model_.arm_to.cast<float>();
  frame.cameras = rig_.cameraCount() < 32 ? (1u << rig_.cameraCount()) - 1 : ~0u;
  return frame;
}

void OutlineFitter::recordOutline(Recorder& recorder, bool find_edges) {
  const std::uint32_t cameras = rig_.cameraCount(), vertices = static_cast<std::uint32_t>(vertices_.count());
  OutlineProjectArgs project{};
  project.cameras = rig_.cameras();
  project.frame = frame_;
  project.pose = pose_;
  project.vertices = vertices_;
  project.pixels = pixels_;
  project.forearms = forearms_;
  project.vertex_count = vertices;
  recorder.dispatch(project_, project, groupsFor(vertices, 4 * kOutlineWorkgroup), cameras);

  if (!find_edges) return;
  recorder.fill(masks_.raw(), 0);
  OutlineMaskArgs mask{};
  mask.cameras = rig_.cameras();
  mask.triangles = triangles_;
  mask.pixels = pixels_;
  mask.masks = masks_;
  mask.triangle_count = static_cast<std::uint32_t>(triangles_.count());
  mask.vertex_count = vertices;
  recorder.dispatch(mask_, mask, groupsFor(triangles_.count(), kOutlineWorkgroup), cameras);

  OutlineListArgs list{};
  list.frame = frame_;
  list.edges = edges_;
  list.pixels = pixels_;
  list.lists = lists_;
  list.edge_count = static_cast<std::uint32_t>(edges_.count());
  list.vertex_count = vertices;
  recorder.dispatch(list_, list, cameras);
}

void OutlineFitter::record(Recorder& recorder, const GpuOutlineFrame& frame, const GpuOutlinePose& start,
                           std::span<const OutlineStage> stages, const Evidence& evidence,
                           const Buffer<std::uint32_t>& images, const Buffer<std::uint32_t>& model,
                           const ScalePrior& scale) {
  frame_.host()[0] = frame;
  pose_.host()[0] = start;
  const std::uint32_t cameras = rig_.cameraCount(), vertices = static_cast<std::uint32_t>(vertices_.count());

  OutlineCoarseArgs coarse{};
  coarse.cameras = rig_.cameras();
  coarse.frame = frame_;
  coarse.pose = pose_;
  coarse.vertices = vertices_;
  coarse.edges = edges_;
  coarse.pixels = pixels_;
  coarse.lists = lists_;
  coarse.masks = masks_;
  coarse.forearms = forearms_;
  coarse.regions = evidence.regions();
  coarse.evidence = evidence.evidence();
  coarse.lines = lines_;
  coarse.vertex_count = vertices;

  OutlineFineArgs fine{};
  fine.cameras = rig_.cameras();
  fine.frame = frame_;
  fine.pose = pose_;
  fine.vertices = vertices_;
  fine.edges = edges_;
  fine.pixels = pixels_;
  fine.lists = lists_;
  fine.masks = masks_;
  fine.forearms = forearms_;
  fine.images = images;
  fine.model = model;
  fine.gains = evidence.gains();
  fine.lines = lines_;
  fine.vertex_count = vertices;

  OutlineSolveArgs solve{};
  solve.lists = lists_;
  solve.lines = lines_;
  solve.pose = pose_;
  solve.result = result_;
  solve.cameras = cameras;
  solve.scale_weight = static_cast<float>(scale.weight);
  solve.prior_scale = static_cast<float>(scale.log_scale);

  const std::uint32_t groups = groupsFor(kOutlineLines, kOutlineWorkgroup);
  for (const OutlineStage& stage : stages) {
    coarse.reach = static_cast<std::uint32_t>(stage.reach);
    coarse.spread = static_cast<float>(stage.spread);
    for (int step = 0; step < stage.steps; ++step) {
      recordOutline(recorder, stage.finds_edges && step == 0);
      if (stage.fine)
        recorder.dispatch(fine_, fine, groups, cameras);
      else
        recorder.dispatch(coarse_, coarse, groups, cameras);
      recorder.dispatch(solve_, solve, 1);
    }
  }
}

GpuOutlinePose outlinePose(const Mat3& rotation, const Vec3& position, double scale) {
  GpuOutlinePose pose;
  pose.rotation = Eigen::Quaterniond(rotation).normalized().coeffs().cast<float>();
  pose.position = position.cast<float>();
  pose.scale = static_cast<float>(scale);
  return pose;
}

GpuOutlinePose noOutlinePose() {
  return outlinePose(Mat3::Identity(), Vec3::Zero(), 1);
}

GpuOutlinePose movedPose(const GpuOutlinePose& pose, const GpuOutlineFrame& frame, double seconds) {
  return outlinePose(rotationFromVector(seconds * frame.spin.cast<double>()) * rotationOf(pose),
                     pose.position.cast<double>() + seconds * frame.velocity.cast<double>(), pose.scale);
}

}  // namespace airclay
