// SPDX-License-Identifier: MIT
#include "engine/synthetic/sensor.h"

#include <algorithm>
#include <cmath>

#include "engine/core/error.h"
#include "shaders/synthetic/sensor.frag.h"
#include "shaders/synthetic/sensor.vert.h"
#include "shaders/synthetic/sensor_backdrop.comp.h"
#include "shaders/synthetic/sensor_compose.comp.h"
#include "shaders/synthetic/sensor_shadow.comp.h"

namespace airclay {
namespace {

/// The direction towards the key light, world: from above and one side.
const Vec3 kKeyDirection = Vec3(0.36, -0.27, 0.9).normalized();
/// Distance of the floor below the cube's centre, in workspace edges; lower if a camera is below it.
constexpr double kFloorBelow = 0.8;
/// The number of skin points that cast the shadow, and its total density where they coincide.
constexpr std::size_t kShadowSpots = 128;
constexpr double kShadowDepth = 3;
/// Backdrop pixels per submission: about 10 ms on two cores.
constexpr std::uint32_t kBandPixels = 50'000;

vec2 keySlope() {
  return vec2(static_cast<float>(kKeyDirection.x() / kKeyDirection.z()),
              static_cast<float>(kKeyDirection.y() / kKeyDirection.z()));
}

/// The rays through every kRayStep-th pixel; zero where there is no ray.
std::vector<vec3> raysOf(const Camera& camera) {
  const auto step = static_cast<int>(kRayStep);
  const auto lines = [step](int pixels) { return (pixels + step - 1) / step + 1; };
  std::vector<vec3> rays;
  for (int row = 0; row < lines(camera.height); ++row)
    for (int column = 0; column < lines(camera.width); ++column) {
      const auto ray = rayThroughPixel(camera.lens, Vec2(column * step, row * step));
      rays.push_back(ray ? vec3(ray->cast<float>()) : vec3(vec3::Zero()));
    }
  return rays;
}

/// The noise table of sensor_io.h. Each channel contains the quantiles of the normal distribution at (i + ½)
/// / count, in an order given by a lattice rule (Korobov 1959) whose multiplier leaves a correlation of 3e-4
/// between channels.
std::vector<std::uint64_t> noiseTable() {
  constexpr std::uint64_t kCount = 1ull << kNoiseBits, kMultiplier = 6693;
  std::vector<std::uint64_t> quantiles;  // quantized
  for (std::uint64_t i = 0; i < kCount; ++i) {
    const double probability = (double(i) + 0.5) / double(kCount);
    double low = -kNoiseReach, high = kNoiseReach;
    for (int step = 0; step < 40; ++step) {
      const double middle = 0.5 * (low + high);
      (0.5 * std::erfc(-middle / std::sqrt(2.0)) < probability ? low : high) = middle;
    }
    quantiles.push_back(static_cast<std::uint64_t>(std::lround((low / kNoiseReach + 1) / 2 * kNoiseSteps)));
  }
  std::vector<std::uint64_t> table;
  for (std::uint64_t i = 0; i < kCount; ++i) {
    const std::uint64_t j = kMultiplier * i % kCount, k = kMultiplier * j % kCount;
    table.push_back(quantiles[i] | quantiles[j] << 21 | quantiles[k] << 42);
  }
  return table;
}

}  // namespace

std::vector<double> openness(const TriangleMesh& mesh, const std::vector<Vec3>& normals) {
  const std::size_t count = mesh.vertices.size();
  std::vector<double> area(count, 0.0);  // a third of each adjoining triangle's area
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto at = [&](int i) { return mesh.vertices[static_cast<std::size_t>(i)]; };
    const double third = (at(b) - at(a)).cross(at(c) - at(a)).norm() / 6;
    for (const int i : {a, b, c}) area[static_cast<std::size_t>(i)] += third;
  }
  std::vector<double> open(count);
  for (std::size_t i = 0; i < count; ++i) {
    double blocked = 0;
    for (std::size_t j = 0; j < count; ++j) {
      const Vec3 away = mesh.vertices[j] - mesh.vertices[i];
      const double square = away.squaredNorm();
      if (square == 0) continue;
      // the disc's form factor if the two face each other
      const double here = normals[i].dot(away), there = -normals[j].dot(away);
      if (here > 0 && there > 0) blocked += area[j] * here * there / (square * (M_PI * square + area[j]));
    }
    open[i] = std::exp(-1.5 * blocked);  // stays above 0 although overlapping discs count twice
  }
  return open;
}

Sensor::Sensor(Gpu& gpu, const GpuRig& rig, const std::vector<TriangleMesh>& meshes)
    : gpu_(gpu),
      rig_(rig),
      mesh_pipeline_(gpu, "sensor hand", {sensor_vert, sensor_frag}),
      shadow_kernel_(gpu, "sensor_shadow", sensor_shadow_comp, {kSensorWorkgroup}),
      compose_hand_(gpu, "sensor_compose", sensor_compose_comp,
                    {kSensorWorkgroup, rig.sameSize()[0], rig.sameSize()[1], 1}),
      compose_empty_(gpu, "sensor_compose_empty", sensor_compose_comp,
                     {kSensorWorkgroup, rig.sameSize()[0], rig.sameSize()[1], 0}),
      backdrop_(gpu, 2 * std::size_t(rig.pixels())),
      shadow_(gpu, kShadowCells * kShadowCells),
      noise_(gpu, noiseTable()),
      hand_(gpu, rig.pixels() + 3),  // the kernel reads four pixels at a time
      images_(gpu, rig.imageWords(), Memory::kHost) {
  uploadMeshes(meshes);
  for (const Camera& camera : rig.rig().cameras) {
    const auto width = static_cast<std::uint32_t>(camera.width),
               height = static_cast<std::uint32_t>(camera.height);
    if (!canvases_.count({width, height})) canvases_[{width, height}] = Canvas(gpu, width, height);
  }
  bakeBackdrop();
}

void Sensor::uploadMeshes(const std::vector<TriangleMesh>& meshes) {
  TriangleMesh all;
  for (const TriangleMesh& mesh : meshes) {
    const int first = static_cast<int>(all.vertices.size());
    all.vertices.insert(all.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    for (const auto& [a, b, c] : mesh.triangles) all.triangles.push_back({first + a, first + b, first + c});
  }
  if (all.triangles.empty()) throw Error("the synthetic cameras need at least one triangle to draw");

  const std::vector<Vec3> unit_normals = vertexNormals(all);
  const std::vector<double> open = openness(all, unit_normals);
  std::vector<vec3> positions, spots;
  std::vector<vec4> normals;
  for (std::size_t i = 0; i < all.vertices.size(); ++i) {
    positions.push_back(all.vertices[i].cast<float>());
    const vec3 normal = unit_normals[i].cast<float>();
    normals.push_back(vec4(normal.x(), normal.y(), normal.z(), static_cast<float>(open[i])));
  }
  const std::size_t step = std::max<std::size_t>(positions.size() / kShadowSpots, 1);
  for (std::size_t i = 0; i < positions.size(); i += step) spots.push_back(positions[i]);
  std::vector<std::uint32_t> indices;
  for (const auto& triangle : all.triangles)
    for (const int i : triangle) indices.push_back(static_cast<std::uint32_t>(i));
  positions_ = Buffer<vec3>(gpu_, positions);
  spots_ = Buffer<vec3>(gpu_, spots);
  normals_ = Buffer<vec4>(gpu_, normals);
  indices_ = Buffer<std::uint32_t>(gpu_, indices);
}

Pose Sensor::workspaceFromWorld() const {
  return Pose(Eigen::Translation3d(-rig_.rig().workspace.center));
}

void Sensor::bakeBackdrop() {
  const double edge_m = rig_.rig().workspace.edge_m;
  floor_z_ = -kFloorBelow * edge_m;
  wall_radius_ = 4 * edge_m;
  std::vector<Pose> workspace_from_camera;
  for (const Camera& camera : rig_.rig().cameras) {
    workspace_from_camera.push_back(workspaceFromWorld() * camera.camera_from_world.inverse());
    const Vec3 eye = workspace_from_camera.back().translation();
    floor_z_ = std::min(floor_z_, eye.z() - 0.3 * edge_m);
    // the cameras are inside the backdrop's curve too
    wall_radius_ = std::max(wall_radius_, 2 * eye.head<2>().norm());
  }

  const Kernel<BackdropArgs> kernel(gpu_, "sensor_backdrop", sensor_backdrop_comp, {kSensorWorkgroup});
  Recorder recorder(gpu_);
  recorder.begin();
  recorder.stage("backdrop");
  std::vector<Buffer<vec3>> rays;
  for (std::size_t i = 0; i < workspace_from_camera.size(); ++i) {
    rays.emplace_back(gpu_, raysOf(rig_.rig().cameras[i]));
    BackdropArgs args{};
    args.rays = rays.back();
    args.backdrop = backdrop_;
    args.workspace_from_camera = workspace_from_camera[i].linear().cast<float>();
    args.eye = workspace_from_camera[i].translation().cast<float>();
    args.width = rig_.camera(i).width;
    args.height = rig_.camera(i).height;
    args.pixels_before = rig_.camera(i).pixels_before;
    args.all_pixels = rig_.pixels();
    args.edge_m = static_cast<float>(edge_m);
    args.floor_z = static_cast<float>(floor_z_);
    args.wall_radius = static_cast<float>(wall_radius_);
    args.key_slope = keySlope();
    const std::uint32_t pixels = args.width * args.height;
    for (; args.first_pixel < pixels; args.first_pixel += kBandPixels) {
      recorder.dispatch(kernel, args,
                        groupsFor(std::min(kBandPixels, pixels - args.first_pixel), kSensorWorkgroup));
      recorder.divide();
    }
  }
  recorder.submitAndWait();
}

void Sensor::recordHand(Recorder& recorder, std::size_t camera, const Pose& world_from_hand) {
  const Pose camera_from_hand = rig_.rig().cameras[camera].camera_from_world * world_from_hand;
  const Mat3 hand_from_world = world_from_hand.linear().transpose();
  SensorMeshArgs args{};
  args.cameras = rig_.cameras();
  args.positions = positions_;
  args.normals = normals_;
  args.camera_from_hand = camera_from_hand.linear().cast<float>();
  args.hand_in_camera = camera_from_hand.translation().cast<float>();
  args.key_in_hand = Vec3(hand_from_world * kKeyDirection).cast<float>();
  args.up_in_hand = Vec3(hand_from_world * Vec3::UnitZ()).cast<float>();
  args.camera = static_cast<std::uint32_t>(camera);

  const GpuCamera& gpu_camera = rig_.camera(camera);
  Canvas& canvas = canvases_.at({gpu_camera.width, gpu_camera.height});
  render(recorder, canvas.pass(vec4(0, 0, 0, 0)), {drawIndexed(mesh_pipeline_, args, indices_)});
  copyToBuffer(recorder, canvas.resolved, hand_.raw(), std::uint64_t(4) * gpu_camera.pixels_before);
}

void Sensor::recordShadow(Recorder& recorder, const Pose& world_from_hand) {
  const Pose workspace_from_hand = workspaceFromWorld() * world_from_hand;
  ShadowArgs args{};
  args.spots = spots_;
  args.shadow = shadow_;
  args.workspace_from_hand = workspace_from_hand.linear().cast<float>();
  args.hand_in_workspace = workspace_from_hand.translation().cast<float>();
  args.spot_count = static_cast<std::uint32_t>(spots_.count());
  args.edge_m = static_cast<float>(rig_.rig().workspace.edge_m);
  args.floor_z = static_cast<float>(floor_z_);
  args.key_slope = keySlope();
  args.spot_weight = static_cast<float>(kShadowDepth / static_cast<double>(spots_.count()));
  recorder.dispatch(shadow_kernel_, args, groupsFor(kShadowCells * kShadowCells, kSensorWorkgroup));
}

void Sensor::record(Recorder& recorder, std::size_t camera, const std::optional<Pose>& world_from_hand,
                    const SensorFrame& frame) {
  if (world_from_hand) {
    if (camera == 0) recordShadow(recorder, *world_from_hand);
    recordHand(recorder, camera, *world_from_hand);
  }
  ComposeArgs args{};
  args.cameras = rig_.cameras();
  args.hand = hand_;
  args.backdrop = backdrop_;
  args.shadow = shadow_;
  args.noise = noise_;
  args.images = images_;
  args.camera = static_cast<std::uint32_t>(camera);
  args.all_pixels = rig_.pixels();
  args.seed = frame.seed;
  args.frame = frame.frame;
  args.noise_sigma = static_cast<float>(frame.noise_sigma);
  args.brightness = static_cast<float>(frame.brightness);
  const GpuCamera& size = rig_.camera(camera);
  recorder.dispatch(world_from_hand ? compose_hand_ : compose_empty_, args,
                    groupsFor((std::size_t(size.width) * size.height + 3) / 4, kSensorWorkgroup));
}

void Sensor::draw(Recorder& recorder, const std::optional<Pose>& world_from_hand, const SensorFrame& frame) {
  for (std::size_t camera = 0; camera < rig_.cameraCount(); ++camera) {
    recorder.begin();
    recorder.stage("sensor");
    record(recorder, camera, world_from_hand, frame);
    recorder.submitAndWait();
  }
}

std::span<const std::uint8_t> Sensor::image(std::size_t camera) const {
  const GpuCamera& gpu_camera = rig_.camera(camera);
  const auto* words = images_.host().data() + gpu_camera.image_words;
  return {reinterpret_cast<const std::uint8_t*>(words),
          std::size_t(3) * gpu_camera.width * gpu_camera.height};
}

std::vector<double> Sensor::coverage(std::size_t camera) const {
  const GpuCamera& gpu_camera = rig_.camera(camera);
  const std::vector<std::uint32_t> rgba = hand_.download();
  std::vector<double> fractions;
  for (std::size_t i = 0; i < std::size_t(gpu_camera.width) * gpu_camera.height; ++i)
    fractions.push_back((rgba[gpu_camera.pixels_before + i] >> 24) / 255.0);
  return fractions;
}

}  // namespace airclay
