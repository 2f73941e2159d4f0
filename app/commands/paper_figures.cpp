// SPDX-License-Identifier: MIT
#include "app/commands/paper_figures.h"

#include <cmath>

#include "app/session/contact_sheet.h"
#include "capture/takes/player.h"
#include "capture/takes/synthetic.h"
#include "engine/clay/clay.h"
#include "engine/clay/presets.h"
#include "engine/core/error.h"
#include "engine/synthetic/demo_scene.h"
#include "engine/synthetic/sensor.h"

namespace airclay {
namespace {

constexpr int kMargin = ContactSheet::kMargin, kGap = ContactSheet::kGap;

/// The hand upright, its back towards -y, centered in the workspace.
Pose uprightHand() {
  Pose pose = Pose::Identity();
  pose.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  pose.translation() = Vec3(0, 0, -0.085);
  return pose;
}

Pose turned(const Pose& pose, const Vec3& about, const Vec3& rotation_vector, const Vec3& moved) {
  return Eigen::Translation3d(about + moved) * Pose(rotationFromVector(rotation_vector)) *
         Eigen::Translation3d(-about) * pose;
}

View nearView(double azimuth_rad, double elevation_rad, double distance_m,
              const Vec3& target = Vec3::Zero()) {
  Orbit orbit;
  orbit.target = target;
  orbit.azimuth_rad = azimuth_rad;
  orbit.elevation_rad = elevation_rad;
  orbit.distance_m = distance_m;
  return orbitView(orbit);
}

/// A camera's image: BGR bytes in the frame's buffer.
RgbaImage cameraImage(const GpuRig& rig, const Buffer<std::uint32_t>& images, std::size_t camera) {
  const GpuCamera& c = rig.camera(camera);
  const auto* bgr = reinterpret_cast<const std::uint8_t*>(images.host().data() + c.image_words);
  RgbaImage image{{static_cast<int>(c.width), static_cast<int>(c.height)}, {}};
  for (std::size_t i = 0; i < std::size_t(c.width) * c.height; ++i)
    image.rgba.insert(image.rgba.end(), {bgr[3 * i + 2], bgr[3 * i + 1], bgr[3 * i], 255});
  return image;
}

/// The part of a mask around its set pixels, unscaled.
RgbaImage maskImage(const Silhouette& mask, ImageSize size) {
  long x_sum = 0, y_sum = 0, count = 0;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (mask.contains(x, y)) {
        x_sum += x;
        y_sum += y;
        ++count;
      }
  if (count == 0) throw Error("a synthetic camera does not see the hand of figure 1");
  const int left = static_cast<int>(x_sum / count) - size.width / 2,
            top = static_cast<int>(y_sum / count) - size.height / 2;
  RgbaImage image{size, {}};
  for (int y = top; y < top + size.height; ++y)
    for (int x = left; x < left + size.width; ++x) {
      const bool inside = x >= 0 && y >= 0 && x < mask.width && y < mask.height;
      if (inside && mask.contains(x, y))
        image.rgba.insert(image.rgba.end(), {243, 238, 230, 255});
      else
        image.rgba.insert(image.rgba.end(), {58, 62, 68, 255});
    }
  return image;
}

/// The synthetic cameras before a hand without its forearm.
struct Photographs {
  std::vector<RgbaImage> images;
  std::vector<Silhouette> masks;
};
Photographs photograph(Gpu& gpu, const GpuRig& rig, const std::vector<TriangleMesh>& meshes,
                       const Pose& world_from_hand) {
  Sensor sensor(gpu, rig, meshes);
  Recorder recorder(gpu);
  sensor.draw(recorder, world_from_hand, {});
  Photographs result;
  for (std::size_t i = 0; i < rig.cameraCount(); ++i) {
    const Camera& camera = rig.rig().cameras[i];
    result.images.push_back(cameraImage(rig, sensor.images(), i));
    Silhouette mask{camera.width, camera.height, {}};
    for (const double share : sensor.coverage(i)) mask.pixels.push_back(share > 0.5 ? 255 : 0);
    result.masks.push_back(std::move(mask));
  }
  return result;
}

/// Fig. 1: silhouettes, and the voxel model that they carve.
RgbaImage voxelModel(Gpu& gpu, const HandModel& hand, int voxels) {
  const GpuRig rig(gpu, demoRig());
  // turned to where four cameras' hull is least swollen: 1.35 times the hand, other ways up to twice
  const Pose world_from_hand = turned(uprightHand(), Vec3::Zero(), Vec3(0.41, -0.18, 0.77), Vec3::Zero());
  const Photographs photographs = photograph(gpu, rig, {hand.skin}, world_from_hand);
  Buffer<std::uint32_t> masks(gpu, rig.maskWords(), Memory::kHost);
  rig.pack(photographs.masks, masks.host());
  Carver carver(gpu, rig, voxels);
  Recorder recorder(gpu);
  recorder.begin();
  recorder.stage("carve");
  carver.record(recorder, masks);
  recorder.submitAndWait();

  Scene scene;
  scene.workspace = rig.rig().workspace;
  scene.voxels = &carver;
  scene.ground_z_m = -0.12;
  ContactSheet page({1280, 960});
  OffscreenRenderer painter(gpu, {928, 912});
  page.lay(painter.paint(scene, nearView(-1.22, 0.3, 0.56, Vec3(0, 0, -0.012))), kMargin, kMargin);
  const ImageSize thumbnail{288, 216};
  for (std::size_t i = 0; i < 4; ++i)
    page.lay(maskImage(photographs.masks[i], thumbnail), kMargin + 928 + kGap,
             kMargin + static_cast<int>(i) * (thumbnail.height + kGap));
  return page.image();
}

/// Fig. 2: links and joints, and the skin around them.
RgbaImage skeletalModel(Gpu& gpu, const HandModel& hand) {
  const RenderMesh skin = RenderMesh::withDistances(gpu, hand.skin);
  const Pose pose = uprightHand();
  const View view = nearView(-1.85, 0.12, 0.52, Vec3(0.004, 0, 0.005));
  Scene scene;
  scene.capsules = skeletonCapsules(hand, pose);
  scene.ground_z_m = -0.125;
  ContactSheet page({1280, 800});
  OffscreenRenderer painter(gpu, {608, 752});
  page.lay(painter.paint(scene, view), kMargin, kMargin);
  SceneHand translucent;
  translucent.skin = &skin;
  translucent.workspace_from_hand = pose;
  translucent.opacity = 0.34;
  scene.hand = translucent;
  page.lay(painter.paint(scene, view), kMargin + 608 + kGap, kMargin);
  return page.image();
}

void addArrow(std::vector<SceneCapsule>& capsules, const Vec3& from, const Vec3& to, double radius_m,
              const vec3& color) {
  const Vec3 along = (to - from).normalized();
  const double head_m = 6 * radius_m;
  capsules.push_back({from, to - head_m * along, radius_m, radius_m, color});
  capsules.push_back({to - head_m * along, to, 2.6 * radius_m, 0.1 * radius_m, color});
}

/// An arrow around an axis through `center`, from the direction `from` by `angle_rad`.
void addArc(std::vector<SceneCapsule>& capsules, const Vec3& center, const Vec3& axis, const Vec3& from,
            double angle_rad, const vec3& color) {
  constexpr int kPieces = 28;
  constexpr double kRadiusM = 0.0016;
  const auto at = [&](double share) {
    return Vec3(center + Eigen::AngleAxisd(share * angle_rad, axis.normalized()) * from);
  };
  for (int i = 0; i < kPieces; ++i)
    capsules.push_back({at(0.72 * i / kPieces), at(0.72 * (i + 1) / kPieces), kRadiusM, kRadiusM, color});
  capsules.push_back({at(0.72), at(1), 2.3 * kRadiusM, 0.1 * kRadiusM, color});
}

/// Fig. 3: the fit's coordinate system, its origin in the hand's centre of gravity, its axes parallel to the
/// world's; the hand is turned by the angle α and moved by d.
RgbaImage coordinateSystem(Gpu& gpu, const HandModel& hand) {
  const RenderMesh skin = RenderMesh::withDistances(gpu, hand.skin);
  const Vec3 centroid_in_hand = massProperties(withCaps(hand.skin)).centroid;
  Pose lying = Pose::Identity();  // fingers along x, back of the hand up
  lying.translation() = -centroid_in_hand;
  const Vec3 d(0.13, 0.12, 0.0);
  const double alpha_rad = 0.62;
  const Pose target = turned(lying, Vec3::Zero(), Vec3(0, 0, alpha_rad), d);

  const vec3 red = colorFromSrgb(200, 64, 52), green = colorFromSrgb(78, 146, 70),
             blue = colorFromSrgb(54, 100, 186);
  const vec3 dark = colorFromSrgb(52, 54, 60), ivory = colorFromSrgb(214, 206, 192);
  Scene scene;
  SceneHand translucent;
  translucent.skin = &skin;
  translucent.workspace_from_hand = lying;
  translucent.opacity = 0.36;
  scene.hand = translucent;
  scene.ground_z_m = -0.085;
  // the pose that the fit finds
  for (SceneCapsule capsule : skeletonCapsules(hand, target)) {
    capsule.albedo = ivory;
    scene.capsules.push_back(capsule);
  }
  scene.capsules.push_back({Vec3::Zero(), Vec3::Zero(), 0.0065, 0.0065, dark});
  addArrow(scene.capsules, Vec3::Zero(), Vec3(0.17, 0, 0), 0.0021, red);
  addArrow(scene.capsules, Vec3::Zero(), Vec3(0, 0.15, 0), 0.0021, green);
  addArrow(scene.capsules, Vec3::Zero(), Vec3(0, 0, 0.13), 0.0021, blue);
  addArrow(scene.capsules, Vec3::Zero(), d, 0.0026, dark);
  addArc(scene.capsules, d, Vec3::UnitZ(), Vec3(0.085, 0, 0), alpha_rad, dark);
  SceneStrokes unturned;  // the direction α = 0
  unturned.host_points = {d, d + Vec3(0.1, 0, 0), d,
                          d + 0.1 * Vec3(std::cos(alpha_rad), std::sin(alpha_rad), 0)};
  unturned.color = dark;
  unturned.width_px = 1.6;
  scene.strokes.push_back(unturned);

  ContactSheet page({1280, 960});
  OffscreenRenderer painter(gpu, {1232, 912});
  page.lay(painter.paint(scene, nearView(-1.2, 0.78, 0.72, Vec3(0.05, 0.035, 0))), kMargin, kMargin);
  return page.image();
}

/// Fig. 4: a cube, and the first three steps of its subdivision.
RgbaImage subdividedCube(Gpu& gpu) {
  const PolygonMesh cage = presetCage("cube");
  double low_z_m = 0;
  for (const Vec3& point : cage.points) low_z_m = std::min(low_z_m, point.z());
  const ImageSize panel{456, 500};
  ContactSheet page({2 * kMargin + 4 * panel.width + 3 * kGap, 2 * kMargin + panel.height});
  OffscreenRenderer painter(gpu, panel);
  for (int level = 0; level <= 3; ++level) {
    PolygonMesh mesh = cage;
    if (level > 0) {
      const Subdivision subdivision = subdivide(cage, level, SubdivisionRule::kCatmullClark);
      mesh.points = dataPoints(subdivision.matrix, cage.points);
      mesh.faces.clear();
      for (const auto& quad : subdivision.quads) mesh.faces.emplace_back(quad.begin(), quad.end());
    }
    const RenderMesh drawn = RenderMesh::faceted(gpu, mesh);
    Scene scene;
    SceneMesh solid;
    solid.surface = drawn.surface();
    solid.open = false;
    scene.meshes.push_back(solid);
    SceneStrokes edges = meshEdges(mesh, scene.workspace);
    edges.width_px = level < 2 ? 3.2 : 2.2;
    edges.color = colorFromSrgb(70, 50, 44);
    scene.strokes.push_back(edges);
    if (level > 0) {
      SceneStrokes initial = meshEdges(cage, scene.workspace);
      initial.width_px = 1.8;
      initial.color = colorFromSrgb(120, 116, 112);
      scene.strokes.push_back(initial);
    }
    scene.ground_z_m = low_z_m - 0.002;
    page.lay(painter.paint(scene, nearView(-1.05, 0.42, 0.95, Vec3(0, 0, -0.01))),
             kMargin + level * (panel.width + kGap), kMargin);
  }
  return page.image();
}

/// A camera's body, seen from outside.
void addCamera(std::vector<SceneCapsule>& capsules, const View& view) {
  const Pose workspace_from_camera = view.camera_from_workspace.inverse();
  const Vec3 eye = workspace_from_camera.translation(), ahead = workspace_from_camera.linear().col(2);
  const vec3 body = colorFromSrgb(74, 78, 86), lens = colorFromSrgb(36, 38, 44);
  capsules.push_back({eye - 0.085 * ahead, eye - 0.035 * ahead, 0.032, 0.036, body});
  capsules.push_back({eye - 0.03 * ahead, eye - 0.004 * ahead, 0.024, 0.028, lens});
}

/// Fig. 5: cameras all around the workspace, hand and clay in it; below, what they see.
RgbaImage cameraSystem(Gpu& gpu, const HandModel& hand) {
  const GpuRig rig(gpu, demoRig());
  const HandScript script = demoScript();
  const Pose world_from_hand = script.at(0.27 * script.endSeconds()).value();
  const Photographs photographs = photograph(gpu, rig, demoArm(), world_from_hand);

  const PolygonMesh cage = presetCage("tube");
  DisplaySurface clay(gpu, cage, SubdivisionRule::kCatmullClark, 2);
  clay.evaluate(cage.points, rig.rig().workspace);
  const DrawnHand drawn(gpu, hand, builtInForearm(false));
  Scene scene;
  scene.workspace = rig.rig().workspace;
  SceneMesh mesh;
  mesh.surface = clay.surface();
  scene.meshes.push_back(mesh);
  scene.hand = drawn.at(workspaceFromWorld(scene.workspace) * world_from_hand);
  scene.hand->opacity = 0.75;
  SceneStrokes frusta = cameraFrusta(rig.rig(), 0.3);
  frusta.width_px = 1.8;
  frusta.color = colorFromSrgb(60, 84, 116);
  SceneStrokes cube = cubeEdges(scene.workspace);
  cube.width_px = 2;
  cube.hidden = 0.25;
  scene.strokes = {cube, frusta};
  for (const Camera& camera : rig.rig().cameras)
    addCamera(scene.capsules, cameraView(camera, scene.workspace));
  scene.ground_z_m = -0.5 * scene.workspace.edge_m;

  ContactSheet page({1280, 960});
  const ImageSize inset{296, 222};
  OffscreenRenderer painter(gpu, {1232, 960 - 2 * kMargin - kGap - inset.height});
  page.lay(painter.paint(scene, nearView(-1.15, 0.36, 3.4, Vec3(0, 0, 0.26))), kMargin, kMargin);
  for (int i = 0; i < 4; ++i)
    page.lay(reduced(photographs.images[static_cast<std::size_t>(i)], inset),
             kMargin + i * (inset.width + kGap), 960 - kMargin - inset.height);
  return page.image();
}

/// The moments of fig. 6 in the demo's script, seconds: next to the clay, pressing, pressed in, away,
/// pressing from above, away.
constexpr double kMoments[] = {1.25, 1.6, 1.95, 2.6, 4.75, 5.4};

/// Fig. 6: the demo's hand deforms the clay, starting from images.
RgbaImage deformation(Gpu& gpu, const HandModel& hand, int voxels, const std::function<void()>& step_done) {
  Synthetic recording(gpu);
  const ClayState clay{presetCage("tube")};
  Pipeline pipeline(gpu, recording.rig(), hand, {voxels}, clay);
  Player player(recording, pipeline);
  DisplaySurface surface(gpu, clay.cage, clay.rule, clay.levels, {.refine_below_points = 200'000});
  const DrawnHand drawn(gpu, hand, builtInForearm(false));
  double low_z_m = 0;
  for (const Vec3& point : pipeline.clay().surface().points) low_z_m = std::min(low_z_m, point.z());

  const ImageSize panel{616, 500};
  ContactSheet page({2 * kMargin + 3 * panel.width + 2 * kGap, 2 * kMargin + 2 * panel.height + kGap});
  OffscreenRenderer painter(gpu, panel);
  std::size_t drawn_panels = 0;
  while (const std::optional<PlayedFrame> frame = player.next()) {
    if (drawn_panels == std::size(kMoments)) break;
    if (frame->time_s < kMoments[drawn_panels] - 1e-6) continue;
    Scene scene;
    scene.workspace = recording.rig().workspace;
    surface.evaluate(pipeline.clay().cage().points, scene.workspace);
    SceneMesh mesh;
    mesh.surface = surface.surface();
    scene.meshes.push_back(mesh);
    if (const HandFit* fit = frame->result.trackedHand())
      scene.hand = drawn.at(workspaceFromWorld(scene.workspace) * fit->pose.world_from_hand);
    scene.ground_z_m = low_z_m - 0.001;
    const int column = static_cast<int>(drawn_panels % 3), row = static_cast<int>(drawn_panels / 3);
    page.lay(painter.paint(scene, nearView(-0.62, 0.45, 0.86, Vec3(0.01, -0.02, 0.015))),
             kMargin + column * (panel.width + kGap), kMargin + row * (panel.height + kGap));
    ++drawn_panels;
    step_done();
  }
  return page.image();
}

}  // namespace

int figureSteps() {
  return 6 + static_cast<int>(std::size(kMoments));
}

void drawFigures(Gpu& gpu, const std::filesystem::path& folder, int voxels,
                 const std::function<void()>& step_done) {
  const HandModel hand = builtInHand(false);
  const auto done = [&](int number, const RgbaImage& image) {
    save(folder / ("figure" + std::to_string(number) + ".png"), image);
    step_done();
  };
  done(1, voxelModel(gpu, hand, voxels));
  done(2, skeletalModel(gpu, hand));
  done(3, coordinateSystem(gpu, hand));
  done(4, subdividedCube(gpu));
  done(5, cameraSystem(gpu, hand));
  done(6, deformation(gpu, hand, voxels, step_done));
}

}  // namespace airclay
