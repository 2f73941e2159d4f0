// SPDX-License-Identifier: MIT
#include "app/session/images.h"

#include <algorithm>

#include "engine/clay/clay.h"

namespace airclay {
namespace {

// Limits a submission at four samples per pixel on a software device, so that the window's images can run
// between.
constexpr std::uint32_t kTrianglesAPiece = 10'000;

}  // namespace

void save(const std::filesystem::path& file, const RgbaImage& image) {
  writePng(file, image.size, image.rgba);
}

OffscreenRenderer::OffscreenRenderer(Gpu& gpu, ImageSize size)
    : renderer_(gpu, {.width = size.width,
                      .height = size.height,
                      .max_submission_triangles = gpu.isCpu() ? kTrianglesAPiece : 0}),
      recorder_(gpu) {}

RgbaImage OffscreenRenderer::paint(const Scene& scene, const View& view) {
  recorder_.begin();
  recorder_.stage("image");
  renderer_.record(recorder_, scene, view);
  recorder_.submitAndWait();
  const std::span<const std::uint8_t> bytes = renderer_.bytes();
  return {{renderer_.width(), renderer_.height()}, {bytes.begin(), bytes.end()}};
}

DrawnHand::DrawnHand(Gpu& gpu, const HandModel& hand, const std::optional<TriangleMesh>& forearm)
    : skin_(RenderMesh::withDistances(gpu, hand.skin)) {
  if (forearm) forearm_.emplace(gpu, *forearm);
}

SceneHand DrawnHand::at(const Pose& workspace_from_hand) const {
  SceneHand hand;
  hand.skin = &skin_;
  hand.workspace_from_hand = workspace_from_hand;
  if (forearm_) hand.forearm = &*forearm_;
  return hand;
}

SculptRenderer::SculptRenderer(Gpu& gpu, Pipeline& pipeline, const ClayState& clay,
                               const std::optional<TriangleMesh>& forearm)
    : pipeline_(pipeline),
      painter_(gpu, kSize),
      hand_(gpu, pipeline.hand(), forearm),
      gpu_(gpu),
      rule_(clay.rule) {
  const Workspace& workspace = pipeline.rig().workspace;
  ground_z_m_ = workspace.edge_m / 2;
  for (const Vec3& point : pipeline.clay().surface().points)
    ground_z_m_ = std::min(ground_z_m_, point.z() - workspace.center.z());
}

Scene SculptRenderer::scene(std::span<const HandPose> hands) {
  Scene scene;
  scene.workspace = pipeline_.rig().workspace;
  scene.ground_z_m = ground_z_m_;
  SceneMesh mesh;
  const PolygonMesh cage = pipeline_.clay().cage();
  if (!surface_ || cage.points.size() != control_points_ || pipeline_.clay().levels() != levels_) {
    control_points_ = cage.points.size();
    levels_ = pipeline_.clay().levels();
    surface_ = std::make_unique<DisplaySurface>(gpu_, cage, rule_, levels_);
  }
  surface_->evaluate(cage.points, scene.workspace);
  mesh.surface = surface_->surface();
  scene.meshes.push_back(mesh);
  if (!hands.empty())
    scene.hand = hand_.at(workspaceFromWorld(scene.workspace) * hands.front().world_from_hand);
  return scene;
}

RgbaImage SculptRenderer::frame(std::span<const HandPose> hands) {
  Orbit orbit;
  orbit.distance_m = 1.3 * pipeline_.rig().workspace.edge_m;
  return painter_.paint(scene(hands), orbitView(orbit));
}

RgbaImage SculptRenderer::workings(std::span<const HandPose> hands) {
  const Clay& clay = pipeline_.clay();
  Scene all = scene(hands);
  const double edge_m = all.workspace.edge_m;
  pipeline_.updateHull();
  all.voxels = &pipeline_.carver();
  all.strokes = {cubeEdges(all.workspace), cameraFrusta(pipeline_.rig(), edge_m / 6)};
  SceneStrokes cage = meshEdges(clay.cage(), all.workspace);
  cage.hidden = 0.3;
  all.strokes.push_back(cage);
  SceneStrokes data_points;
  data_points.points = &clay.dataPoints();
  data_points.workspace_from_strokes = Pose(clay.workspaceFromClay());
  data_points.dots = true;
  data_points.width_px = 3;
  all.strokes.push_back(data_points);
  Orbit orbit;
  orbit.target.z() = 0.5 * edge_m;
  orbit.distance_m = 6 * edge_m;
  return painter_.paint(all, orbitView(orbit));
}

}  // namespace airclay
