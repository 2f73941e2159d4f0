// SPDX-License-Identifier: MIT
#include "app/pictures.h"

#include <algorithm>

#include "engine/clay.h"

namespace airclay {
namespace {

constexpr int kGap = 6;  ///< pixels between a montage's panels

}  // namespace

void save(const std::filesystem::path& file, const Picture& picture) {
  writePng(file, picture.size, picture.rgba);
}

Picture montage(const std::vector<Picture>& panels, int columns) {
  const PictureSize panel = panels.at(0).size;
  const int rows = (static_cast<int>(panels.size()) + columns - 1) / columns;
  Picture whole;
  whole.size = {columns * panel.width + (columns - 1) * kGap, rows * panel.height + (rows - 1) * kGap};
  whole.rgba.assign(std::size_t(4) * std::size_t(whole.size.width) * std::size_t(whole.size.height), 255);
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const int left = static_cast<int>(i) % columns * (panel.width + kGap);
    const int top = static_cast<int>(i) / columns * (panel.height + kGap);
    for (int y = 0; y < panel.height; ++y) {
      const auto row = panels[i].rgba.begin() + std::ptrdiff_t(4) * y * panel.width;
      std::copy(row, row + std::ptrdiff_t(4) * panel.width,
                whole.rgba.begin() + 4 * (std::ptrdiff_t(top + y) * whole.size.width + left));
    }
  }
  return whole;
}

Painter::Painter(Gpu& gpu, PictureSize size)
    : renderer_(gpu, {.width = size.width, .height = size.height}), recorder_(gpu) {}

Picture Painter::paint(const Scene& scene, const View& view) {
  recorder_.begin();
  recorder_.stage("picture");
  renderer_.record(recorder_, scene, view);
  recorder_.submitAndWait();
  const std::span<const std::uint8_t> bytes = renderer_.bytes();
  return {{renderer_.width(), renderer_.height()}, {bytes.begin(), bytes.end()}};
}

DrawnHand::DrawnHand(Gpu& gpu, const HandModel& hand, const std::optional<TriangleMesh>& forearm)
    : skin_(DrawnMesh::withDistances(gpu, hand.skin)) {
  if (forearm) forearm_.emplace(gpu, *forearm);
}

SceneHand DrawnHand::at(const Pose& workspace_from_hand) const {
  SceneHand hand;
  hand.skin = &skin_;
  hand.workspace_from_hand = workspace_from_hand;
  if (forearm_) hand.forearm = &*forearm_;
  return hand;
}

SculptPictures::SculptPictures(Gpu& gpu, const Pipeline& pipeline, const std::optional<TriangleMesh>& forearm)
    : pipeline_(pipeline), painter_(gpu, kSize), hand_(gpu, pipeline.hand(), forearm) {
  const Workspace& workspace = pipeline.rig().workspace;
  ground_z_m_ = workspace.edge_m / 2;
  for (const Vec3& point : pipeline.clay().surface().points)
    ground_z_m_ = std::min(ground_z_m_, point.z() - workspace.center.z());
}

Scene SculptPictures::scene(const std::optional<Pose>& world_from_hand) const {
  const Clay& clay = pipeline_.clay();
  Scene scene;
  scene.workspace = pipeline_.rig().workspace;
  scene.ground_z_m = ground_z_m_;
  SceneMesh mesh;
  mesh.surface = {&clay.dataPoints(), &clay.normals(), &clay.triangles()};
  scene.meshes.push_back(mesh);
  if (world_from_hand) scene.hand = hand_.at(workspaceFromWorld(scene.workspace) * *world_from_hand);
  return scene;
}

Picture SculptPictures::frame(const std::optional<Pose>& world_from_hand) {
  Orbit orbit;
  orbit.distance_m = 1.55 * pipeline_.rig().workspace.edge_m;
  return painter_.paint(scene(world_from_hand), orbitView(orbit));
}

Picture SculptPictures::workings(const std::optional<Pose>& world_from_hand) {
  const Clay& clay = pipeline_.clay();
  Scene all = scene(world_from_hand);
  const double edge_m = all.workspace.edge_m;
  all.voxels = &pipeline_.carver();
  all.strokes = {cubeEdges(all.workspace), cameraFrusta(pipeline_.rig(), edge_m / 6)};
  SceneStrokes cage = meshEdges(clay.cage(), all.workspace);
  cage.hidden = 0.3;
  all.strokes.push_back(cage);
  SceneStrokes data_points;
  data_points.points = &clay.dataPoints();
  data_points.dots = true;
  data_points.width_px = 3;
  all.strokes.push_back(data_points);
  Orbit orbit;
  orbit.distance_m = 6 * edge_m;
  return painter_.paint(all, orbitView(orbit));
}

}  // namespace airclay
