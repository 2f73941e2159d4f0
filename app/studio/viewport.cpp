// SPDX-License-Identifier: MIT
#include "app/studio/viewport.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "engine/clay/clay.h"

namespace airclay {
namespace {

constexpr double kRingAway = 1.06;  // relative to the clay's extent, so that symmetry rings do not touch it

/// 15 cm: the distance is not shown beyond this.
constexpr double kFarthestGap = 0.15;
/// Triangle budget of a software device at the cameras' rate; a triangle costs as much as a hundred pixels.
constexpr DisplayDetail kMovingDetail = {.refine_below_points = 3'000, .coarsen_above_points = 30'000};
/// More are not distinguishable and would delay the first image of a movement.
constexpr DisplayDetail kRestingDetail = {.coarsen_above_points = 150'000};
constexpr int kMovingTaps = 8, kMovingShadowMap = 320, kMovingGround = 40;

/// Everything that an image depends on.
std::vector<double> keyOf(const Session::ClayOnDevice& clay, const Snapshot& snapshot,
                          const StudioSettings& settings, const ViewportFrame& frame) {
  std::vector<double> key = {double(frame.width),           double(frame.height),
                             double(frame.moving),          double(clay.structure_serial),
                             double(snapshot.clay_serial),  double(snapshot.trust),
                             double(settings.show_voxels),  double(settings.show_cage),
                             double(settings.show_points),  double(settings.show_skeleton),
                             double(settings.show_cameras), frame.view.vertical_fov_rad,
                             double(settings.symmetry.x),   double(settings.symmetry.y),
                             double(settings.symmetry.z)};
  if (settings.show_voxels) key.push_back(double(snapshot.serial));
  const auto add = [&](const Pose& pose) {
    const Eigen::Matrix4d matrix = pose.matrix();
    key.insert(key.end(), matrix.data(), matrix.data() + matrix.size());
  };
  add(frame.view.camera_from_workspace);
  for (const HandPose& hand : snapshot.hands) add(hand.world_from_hand);
  return key;
}

}  // namespace

Viewport::Viewport(Gpu& gpu, const Session& session, const std::optional<TriangleMesh>& forearm)
    : gpu_(gpu), session_(session), hand_(gpu, session.hand(), forearm) {
  std::map<std::pair<int, int>, std::size_t> found;
  const std::vector<std::array<int, 3>>& triangles = session.hand().skin.triangles;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      const auto [at, is_new] = found.try_emplace(std::minmax(a, b), skin_edges_.size());
      if (is_new)
        skin_edges_.push_back({a, b, static_cast<int>(t), -1});
      else
        skin_edges_[at->second].right = static_cast<int>(t);
    }
}

void Viewport::measure(const Snapshot& snapshot, const std::optional<Pose>& workspace_from_hand) {
  Eigen::AlignedBox3d box;
  for (const vec3& point : snapshot.clay_points) box.extend(point.cast<double>());
  clay_center_ = box.center();
  clay_radius_m_ = 0.5 * box.diagonal().norm();
  ground_z_m_ = std::min(-0.3 * session_.rig().workspace.edge_m, box.min().z() - 0.01);
  clay_reach_m_ = 0;
  for (const vec3& point : snapshot.clay_points)
    clay_reach_m_ = std::max(clay_reach_m_, double(point.norm()));
  gap_m_.reset();
  if (!workspace_from_hand) return;
  const Pose hand_from_workspace = workspace_from_hand->inverse();
  double nearest = std::numeric_limits<double>::infinity();
  for (const vec3& point : snapshot.clay_points)
    nearest = std::min(nearest, sample(hand_.grid(), hand_from_workspace * point.cast<double>()));
  if (nearest < kFarthestGap) gap_m_ = nearest;
}

Renderer& Viewport::rendererFor(int width, int height, bool moving) {
  const bool software = gpu_.isCpu();
  RendererOptions options;
  options.width = width;
  options.height = height;
  if (software) options = RendererOptions::live(width, height);
  if (software && moving) {
    options.shadow_taps = kMovingTaps;
    options.shadow_map = kMovingShadowMap;
    options.ground_vertices = kMovingGround;
  }
  options.readback = false;
  std::unique_ptr<Renderer>& renderer = renderers_[software && moving];
  if (!renderer || renderer->width() != options.width || renderer->height() != options.height)
    renderer = std::make_unique<Renderer>(gpu_, options);
  return *renderer;
}

/// Reevaluates the surface only if the clay has moved.
SurfaceBuffers Viewport::recordSurface(Recorder& recorder, const Session::ClayOnDevice& clay,
                                       std::uint64_t clay_serial, bool moving) {
  const bool coarse = gpu_.isCpu() && moving;
  DrawnClay& drawn = clays_[coarse];
  if (drawn.structure_serial != clay.structure_serial) {
    drawn.surface = std::make_unique<DisplaySurface>(gpu_, clay.structure.cage, clay.structure.rule,
                                                     clay.structure.levels,
                                                     coarse         ? kMovingDetail
                                                     : gpu_.isCpu() ? kRestingDetail
                                                                    : DisplayDetail{});
    drawn.structure_serial = clay.structure_serial;
    drawn.clay_serial = 0;
  }
  if (drawn.clay_serial != clay_serial) drawn.surface->record(recorder, clay.clay.controlPoints());
  drawn.clay_serial = clay_serial;
  return drawn.surface->surface();
}

void Viewport::record(Recorder& recorder, const Session::ClayOnDevice& clay, const Snapshot& snapshot,
                      const StudioSettings& settings, const ViewportFrame& frame) {
  std::optional<Pose> workspace_from_hand;
  if (!snapshot.hands.empty())
    workspace_from_hand =
        workspaceFromWorld(session_.rig().workspace) * snapshot.hands.front().world_from_hand;
  measure(snapshot, workspace_from_hand);

  Renderer& renderer = rendererFor(frame.width, frame.height, frame.moving);
  std::vector<double> key = keyOf(clay, snapshot, settings, frame);
  if (&renderer == drawn_ && key == drawn_key_) return;
  drawn_ = &renderer;
  drawn_key_ = std::move(key);
  recorder.stage("image: surface");
  const SurfaceBuffers surface = recordSurface(recorder, clay, snapshot.clay_serial, frame.moving);
  Scene scene = sceneOf(clay, snapshot, settings, workspace_from_hand);
  scene.meshes.push_back({.surface = surface, .workspace_from_mesh = snapshot.workspace_from_clay});
  drawn_->record(recorder, scene, frame.view);
}

Scene Viewport::sceneOf(const Session::ClayOnDevice& clay, const Snapshot& snapshot,
                        const StudioSettings& settings, const std::optional<Pose>& workspace_from_hand) {
  const Workspace& workspace = session_.rig().workspace;
  Scene scene;
  scene.workspace = workspace;
  scene.ground_z_m = ground_z_m_;
  if (workspace_from_hand) {
    scene.hand = hand_.at(*workspace_from_hand);
    if (snapshot.trust != TrackingState::kTracking) scene.hand->opacity *= 0.5;
  }
  if (settings.show_voxels && session_.hasRecording()) scene.voxels = &session_.carver();
  if (settings.show_cameras) {
    scene.strokes.push_back(cubeEdges(workspace));
    scene.strokes.push_back(cameraFrusta(session_.rig(), workspace.edge_m / 6));
  }
  const bool mirrored[3] = {settings.symmetry.x, settings.symmetry.y, settings.symmetry.z};
  for (int axis = 0; axis < 3; ++axis)
    if (mirrored[axis]) {
      SceneStrokes ring = symmetryRing(axis, kRingAway * clay_reach_m_);
      ring.workspace_from_strokes = snapshot.workspace_from_clay;
      scene.strokes.push_back(std::move(ring));
    }
  if (settings.show_cage) {
    if (cage_structure_serial_ != clay.structure_serial) {
      cage_edges_ = Buffer<std::uint32_t>(gpu_, edgeIndices(clay.structure.cage.faces));
      cage_structure_serial_ = clay.structure_serial;
    }
    SceneStrokes cage;
    cage.points = &clay.clay.controlPoints();
    cage.workspace_from_strokes = snapshot.workspace_from_clay;
    cage.indices = &cage_edges_;
    cage.hidden = 0.3;
    scene.strokes.push_back(std::move(cage));
  }
  if (settings.show_points) {
    SceneStrokes points;
    points.points = &clay.clay.dataPoints();
    points.workspace_from_strokes = snapshot.workspace_from_clay;
    points.dots = true;
    points.width_px = 4;
    scene.strokes.push_back(std::move(points));
  }
  if (settings.show_skeleton && workspace_from_hand)
    scene.capsules = skeletonCapsules(session_.hand(), *workspace_from_hand);
  return scene;
}

std::vector<std::pair<Vec2, Vec2>> Viewport::outline(std::size_t camera, const Pose& world_from_hand) const {
  const Camera& seen_by = session_.rig().cameras[camera];
  const TriangleMesh& skin = session_.hand().skin;
  const Vec3 eye_in_hand = (seen_by.camera_from_world * world_from_hand).inverse().translation();
  std::vector<char> faces_camera;
  for (const auto& [a, b, c] : skin.triangles) {
    const Vec3& corner = skin.vertices[std::size_t(a)];
    const Vec3 normal =
        (skin.vertices[std::size_t(b)] - corner).cross(skin.vertices[std::size_t(c)] - corner);
    faces_camera.push_back(normal.dot(eye_in_hand - corner) > 0);
  }
  std::vector<std::pair<Vec2, Vec2>> lines;
  for (const SkinEdge& edge : skin_edges_) {
    if (edge.right >= 0 && faces_camera[std::size_t(edge.left)] == faces_camera[std::size_t(edge.right)])
      continue;
    const auto a = project(seen_by, world_from_hand * skin.vertices[std::size_t(edge.a)]);
    const auto b = project(seen_by, world_from_hand * skin.vertices[std::size_t(edge.b)]);
    if (a && b) lines.emplace_back(*a, *b);
  }
  return lines;
}

}  // namespace airclay
