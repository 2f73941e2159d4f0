// SPDX-License-Identifier: MIT
// `airclay figures`: the paper's figures 1 to 6, drawn from our own data: the demo's hand, cameras and clay.
#include <CLI/CLI.hpp>
#include <memory>

#include "app/command.h"
#include "app/outputs.h"
#include "app/pictures.h"
#include "app/player.h"
#include "app/progress.h"
#include "capture/synthetic.h"
#include "engine/clay.h"
#include "engine/error.h"
#include "engine/presets.h"

namespace airclay {
namespace {

constexpr PictureSize kFigure = {960, 720}, kPanel = {640, 480};

/// From above the palm's thumb side, near enough that the hand fills the picture.
View handView(const Vec3& target) {
  Orbit orbit;
  orbit.target = target;
  orbit.azimuth_rad = -0.9;
  orbit.elevation_rad = 0.75;
  orbit.distance_m = 0.5;
  return orbitView(orbit);
}

/// Fig. 1: the voxel model that the last frame was carved to.
Picture voxelModel(Gpu& gpu, const Pipeline& pipeline, const Vec3& hand_in_workspace) {
  Scene scene;
  scene.workspace = pipeline.rig().workspace;
  scene.voxels = &pipeline.carver();
  return Painter(gpu, kFigure).paint(scene, handView(hand_in_workspace));
}

/// Fig. 2: links and joints inside the skin.
Picture skeletalModel(Gpu& gpu, const HandModel& hand, const Pose& workspace_from_hand, const Vec3& target) {
  const DrawnHand drawn(gpu, hand, std::nullopt);
  Scene scene;
  scene.hand = drawn.at(workspace_from_hand);
  scene.capsules = skeletonCapsules(hand, workspace_from_hand);
  return Painter(gpu, kFigure).paint(scene, handView(target));
}

/// Three arrows, red, green and blue for x, y and z.
std::vector<SceneCapsule> axes(const Pose& workspace_from_axes, double length_m) {
  std::vector<SceneCapsule> capsules;
  const vec3 colors[] = {fromScreen(196, 62, 50), fromScreen(74, 140, 62), fromScreen(52, 98, 180)};
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 direction = workspace_from_axes.linear().col(axis);
    const Vec3 origin = workspace_from_axes.translation(), shoulder = origin + length_m * direction;
    capsules.push_back({origin, shoulder, 0.0025, 0.0025, colors[axis]});
    capsules.push_back({shoulder, shoulder + 0.2 * length_m * direction, 0.007, 0, colors[axis]});
  }
  return capsules;
}

/// Fig. 3: the coordinate system, its origin the hand's centre of gravity.
Picture coordinateSystem(Gpu& gpu, const HandModel& hand, const Pose& workspace_from_hand) {
  const DrawnHand drawn(gpu, hand, std::nullopt);
  Pose workspace_from_axes = workspace_from_hand;
  workspace_from_axes.translation() = workspace_from_hand * massProperties(hand.skin).centroid;
  Scene scene;
  scene.hand = drawn.at(workspace_from_hand);
  scene.capsules = axes(workspace_from_axes, 0.11);
  return Painter(gpu, kFigure).paint(scene, handView(workspace_from_axes.translation()));
}

/// Fig. 4: a cube, once and twice subdivided.
Picture subdividedCube(Gpu& gpu) {
  PolygonMesh mesh = presetCage("cube");
  std::vector<Picture> panels;
  Painter painter(gpu, kPanel);
  const PolygonMesh cage = mesh;
  for (int level = 0; level <= 2; ++level) {
    if (level > 0) {
      const Subdivision subdivision = subdivide(cage, level, SubdivisionRule::kCatmullClark);
      mesh.points = dataPoints(subdivision.matrix, cage.points);
      mesh.faces.clear();
      for (const std::array<int, 4>& quad : subdivision.quads)
        mesh.faces.emplace_back(quad.begin(), quad.end());
    }
    const DrawnMesh drawn = DrawnMesh::faceted(gpu, mesh);
    Scene scene;
    SceneMesh solid;
    solid.surface = drawn.surface();
    solid.open = false;
    scene.meshes.push_back(solid);
    scene.strokes.push_back(meshEdges(mesh, scene.workspace));
    Orbit orbit;
    orbit.distance_m = 0.75;
    panels.push_back(painter.paint(scene, orbitView(orbit)));
  }
  return montage(panels, 3);
}

/// Fig. 5: the cameras about the workspace, hand and clay in it.
Picture cameraSystem(Gpu& gpu, const Pipeline& pipeline, const DrawnHand& hand,
                     const Pose& workspace_from_hand) {
  const Clay& clay = pipeline.clay();
  Scene scene;
  scene.workspace = pipeline.rig().workspace;
  SceneMesh mesh;
  mesh.surface = {&clay.dataPoints(), &clay.normals(), &clay.triangles()};
  scene.meshes.push_back(mesh);
  scene.hand = hand.at(workspace_from_hand);
  scene.strokes = {cubeEdges(scene.workspace), cameraFrusta(pipeline.rig(), 0.15)};
  scene.ground_z_m = -scene.workspace.edge_m / 2;
  Orbit orbit;
  orbit.target = Vec3(0, 0, 0.15);
  orbit.distance_m = 4.6;
  return Painter(gpu, kFigure).paint(scene, orbitView(orbit));
}

/// The frames of fig. 6, as shares of the recording.
constexpr double kMoments[] = {0.12, 0.3, 0.48, 0.66, 0.84, 1.0};

struct FigureOptions : CommonOptions {
  std::string out;
};

void runFigures(const FigureOptions& options) {
  checkVoxels(options.voxels);
  makeFolder(options.out);
  const std::filesystem::path out = options.out;
  CommandGpu gpu(options);
  Synthetic recording(gpu);
  const HandModel hand = builtInHand(false);
  Pipeline pipeline(gpu, recording.rig(), hand, {options.voxels}, ClayOptions{presetCage("tube")});
  SculptPictures sculpt_pictures(gpu, pipeline, builtInForearm(false));
  const DrawnHand drawn_hand(gpu, hand, builtInForearm(false));

  Player player(recording, pipeline);
  std::vector<Picture> panels;
  Progress progress("drawing", recording.frameCount(), options.talks());
  while (const std::optional<PlayedFrame> played = player.next()) {
    progress.advance();
    const int last = recording.frameCount() - 1;
    if (panels.size() == std::size(kMoments) || played->frame < kMoments[panels.size()] * last) continue;
    if (played->result.hand != HandState::kTracked)
      throw Error("frame " + std::to_string(played->frame) + " of the demo: the hand was not found");
    const Pose& world_from_hand = played->result.fit.world_from_hand;
    panels.push_back(sculpt_pictures.frame(world_from_hand));
    if (panels.size() != std::size(kMoments) / 2) continue;
    const Pose workspace_from_hand = workspaceFromWorld(recording.rig().workspace) * world_from_hand;
    const Vec3 center = workspace_from_hand * massProperties(hand.skin).centroid;
    save(out / "figure1.png", voxelModel(gpu, pipeline, center));
    save(out / "figure2.png", skeletalModel(gpu, hand, workspace_from_hand, center));
    save(out / "figure3.png", coordinateSystem(gpu, hand, workspace_from_hand));
    save(out / "figure5.png", cameraSystem(gpu, pipeline, drawn_hand, workspace_from_hand));
  }
  save(out / "figure4.png", subdividedCube(gpu));
  save(out / "figure6.png", montage(panels, 3));
  say(options, "figure1.png to figure6.png in " + options.out);
}

}  // namespace

void addFigures(CLI::App& program, int&) {
  CLI::App* command = program.add_subcommand("figures", "draw the paper's figures 1 to 6 from our own data");
  const auto options = std::make_shared<FigureOptions>();
  command->add_option("--out", options->out, "the folder that figure1.png to figure6.png go to")
      ->type_name("DIR")
      ->required();
  addCommonOptions(*command, *options, Uses::kDeviceAndVoxels, false);
  command->callback([options] { runFigures(*options); });
}

}  // namespace airclay
