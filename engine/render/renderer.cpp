// SPDX-License-Identifier: MIT
#include "engine/render/renderer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/core/error.h"
#include "engine/hull/carve.h"
#include "engine/render/renderer_parts.h"

namespace airclay {
namespace {

/// A pose in the format of the kernels' arguments.
struct RigidTransform {
  mat3 rotation;
  vec3 translation;
};
RigidTransform rigidTransform(const Pose& workspace_from_mesh) {
  return {workspace_from_mesh.linear().cast<float>(), workspace_from_mesh.translation().cast<float>()};
}

/// Replaces a buffer of fewer than `count` values with one of twice that size.
template <class T>
void grow(Gpu& gpu, Buffer<T>& buffer, std::size_t count, Memory memory) {
  if (buffer.count() < std::max<std::size_t>(count, 1))
    buffer = Buffer<T>(gpu, 2 * std::max<std::size_t>(count, 1), memory);
}

/// Perspective projection for OpenCV camera axes: y down, depth 0 to 1 between the planes.
Eigen::Matrix4d clipFromCamera(const View& view, double aspect, double near_m, double far_m) {
  const double focal = 1 / std::tan(0.5 * view.vertical_fov_rad);
  Eigen::Matrix4d clip = Eigen::Matrix4d::Zero();
  clip(0, 0) = focal / aspect;
  clip(1, 1) = focal;
  clip(0, 2) = 2 * view.axis_shift.x() / aspect;
  clip(1, 2) = 2 * view.axis_shift.y();
  clip(2, 2) = far_m / (far_m - near_m);
  clip(2, 3) = -far_m * near_m / (far_m - near_m);
  clip(3, 2) = 1;
  return clip;
}

/// The key light is to the left of the eye, above and slightly in front of the scene.
Vec3 keyDirection(const View& view) {
  Vec3 right = view.camera_from_workspace.linear().row(0).transpose();
  right.z() = 0;
  right = right.norm() > 1e-6 ? right.normalized() : Vec3::UnitX();
  const Vec3 towards_eye = right.cross(Vec3::UnitZ());
  return (-0.62 * right + 0.42 * towards_eye + 0.95 * Vec3::UnitZ()).normalized();
}

}  // namespace

Renderer::Renderer(Gpu& gpu, const RendererOptions& options) : gpu_(gpu), options_(options) {
  if (options.width < 1 || options.height < 1 ||
      std::max(options.width, options.height) > RendererOptions::kMaxImage)
    throw Error("an image of " + std::to_string(options.width) + " x " + std::to_string(options.height) +
                " pixels cannot be drawn; expected 1 to " + std::to_string(RendererOptions::kMaxImage) +
                " pixels per side");
  const auto width = static_cast<std::uint32_t>(options.width),
             height = static_cast<std::uint32_t>(options.height);
  const auto shadow = static_cast<std::uint32_t>(options.shadow_map);
  const std::uint32_t samples = options.multisample ? kSamples : 1;
  const ImageKind kind = options.readback ? ImageKind::kColor : ImageKind::kScreen;
  pipelines_ = std::make_unique<Pipelines>(gpu, TargetFormat{kind, samples});
  color_ = Image(gpu, kind, width, height, samples);
  depth_ = Image(gpu, ImageKind::kDepth, width, height, samples);
  (options.multisample ? resolved_ : backdrop_) = Image(gpu, kind, width, height);
  shadow_image_ = Image(gpu, ImageKind::kDepth, shadow, shadow);
  shadow_map_ = Buffer<float>(gpu, std::size_t(shadow) * shadow);
  frame_ = Buffer<RenderFrame>(gpu, 1, Memory::kHost);
  if (options.readback) pixels_ = Buffer<std::uint32_t>(gpu, std::size_t(width) * height, Memory::kHost);

  // the ground's grid, from -1 to 1; cells grow from the middle outwards
  const auto side = static_cast<std::uint32_t>(options.ground_vertices);
  const auto place = [&](std::uint32_t i) {
    const float even = 2.0f * static_cast<float>(i) / static_cast<float>(side - 1) - 1;
    return 0.4f * even + 0.6f * even * even * even;
  };
  std::vector<vec3> ground;
  for (std::uint32_t y = 0; y < side; ++y)
    for (std::uint32_t x = 0; x < side; ++x) ground.emplace_back(place(x), place(y), 0.0f);
  ground_triangles_ = Buffer<std::uint32_t>(gpu, 6 * (side - 1) * (side - 1));
  ground_positions_ = Buffer<vec3>(gpu, ground);
  ground_normals_ = Buffer<vec3>(gpu, std::vector<vec3>(ground.size(), vec3(0, 0, 1)));
  ground_lights_ = Buffer<VertexLight>(gpu, ground.size());
  areas_ = Buffer<std::uint32_t>(gpu, kDensityCells * kDensityCells * kDensityCells);
  densities_ = Buffer<float>(gpu, kDensityTotal);
}

Renderer::~Renderer() = default;

std::span<const std::uint8_t> Renderer::bytes() const {
  const std::span<const std::uint32_t> words = pixels();
  return {reinterpret_cast<const std::uint8_t*>(words.data()), words.size_bytes()};
}

void Renderer::record(Recorder& recorder, const Scene& scene, const View& view) {
  submission_triangles_ = 0;
  prepare(scene);
  setTransforms(scene, view);
  writeFrame(scene);
  writeStrokes(scene);

  recorder.stage("image: shadow");
  if (scene.voxels) recordVoxelList(recorder, scene);
  recordDensities(recorder, scene);
  recordShadowMap(recorder, scene);
  recorder.stage("image: light");
  recordLights(recorder, scene);
  divideIfLarge(recorder);
  recorder.stage("image: draw");
  recordFrame(recorder, scene);
  if (!options_.readback) divideIfLarge(recorder);  // a window records more commands
}

void Renderer::prepare(const Scene& scene) {
  lit_meshes_.clear();
  const auto add = [&](const SurfaceBuffers& surface, const Pose& workspace_from_mesh) -> LitMesh& {
    if (!surface.positions || !surface.normals || !surface.triangles)
      throw Error("a surface to draw has no positions, normals or triangles", Fault::kDevice);
    LitMesh mesh;
    mesh.surface = surface;
    mesh.workspace_from_mesh = workspace_from_mesh;
    return lit_meshes_.emplace_back(mesh);
  };
  for (const SceneMesh& mesh : scene.meshes) {
    LitMesh& lit = add(mesh.surface, mesh.workspace_from_mesh);
    lit.albedo = mesh.albedo;
    lit.open = mesh.open;
    lit.shows_touch = mesh.shows_touch;
  }
  if (scene.hand) {
    // the forearm first, so that the hand's skin is visible where both overlap
    for (const RenderMesh* part : {scene.hand->forearm, scene.hand->skin}) {
      if (!part) continue;
      LitMesh& mesh = add(part->surface(), scene.hand->workspace_from_hand);
      mesh.albedo = scene.hand->albedo;
      mesh.opacity = scene.hand->opacity;
      mesh.is_hand = true;
      mesh.is_forearm = part == scene.hand->forearm;
    }
  }

  std::uint32_t vertices = 0;
  for (LitMesh& mesh : lit_meshes_) {
    mesh.first_light = vertices;
    vertices += static_cast<std::uint32_t>(mesh.surface.positions->count());
  }
  grow(gpu_, lights_, vertices, Memory::kDevice);
  if (scene.voxels && (!voxels_ || voxels_->voxels != scene.voxels->voxels()))
    voxels_ = std::make_unique<Voxels>(gpu_, *scene.voxels);
}

void Renderer::setTransforms(const Scene& scene, const View& view) {
  const double edge_m = scene.workspace.edge_m;
  const double aspect = static_cast<double>(options_.width) / options_.height;
  transforms_.clip_from_workspace =
      clipFromCamera(view, aspect, edge_m / 40, edge_m * 40) * view.camera_from_workspace.matrix();
  transforms_.eye = view.camera_from_workspace.inverse().translation();
  transforms_.key_direction = keyDirection(view);

  // the shadow map covers the sphere around the cube, with a depth range for parts outside it
  transforms_.light_radius_m = 0.87 * edge_m;
  transforms_.light_depth_m = 4 * edge_m;
  const View from_light = lookAt(transforms_.key_direction * 0.5 * transforms_.light_depth_m, Vec3::Zero());
  transforms_.light_from_workspace = from_light.camera_from_workspace.matrix();
  transforms_.light_from_workspace.topRows<2>() /= transforms_.light_radius_m;
  transforms_.light_from_workspace.row(2) /= transforms_.light_depth_m;
}

void Renderer::writeFrame(const Scene& scene) {
  RenderFrame frame{};
  for (int row = 0; row < 3; ++row)
    frame.light_row[row] = transforms_.light_from_workspace.row(row).transpose().cast<float>();
  frame.key_direction = transforms_.key_direction.cast<float>();
  frame.shadow_size = static_cast<std::uint32_t>(options_.shadow_map);
  frame.shadow_texel_m = static_cast<float>(2 * transforms_.light_radius_m / options_.shadow_map);
  frame.shadow_depth_m = static_cast<float>(transforms_.light_depth_m);
  frame.shadow_taps = static_cast<std::uint32_t>(options_.shadow_taps);
  frame.edge_m = static_cast<float>(scene.workspace.edge_m);
  if (scene.hand && scene.hand->skin && !scene.hand->skin->grid().values.empty()) {
    const DistanceGrid& grid = scene.hand->skin->grid();
    const RigidTransform hand = rigidTransform(scene.hand->workspace_from_hand.inverse());
    frame.hand_from_workspace = hand.rotation;
    frame.workspace_in_hand = hand.translation;
    frame.grid_low_corner = grid.low_corner.cast<float>();
    frame.grid_cell_m = static_cast<float>(grid.cell_m);
    for (std::size_t i = 0; i < 3; ++i) frame.grid_size[i] = static_cast<std::uint32_t>(grid.size[i]);
  }
  frame_.host()[0] = frame;
}

void Renderer::writeStrokes(const Scene& scene) {
  std::size_t points = 0;
  for (const SceneStrokes& strokes : scene.strokes)
    if (!strokes.points) points += strokes.host_points.size();
  grow(gpu_, stroke_points_, points, Memory::kHost);
  std::size_t at = 0;
  for (const SceneStrokes& strokes : scene.strokes)
    if (!strokes.points)
      for (const Vec3& point : strokes.host_points) stroke_points_.host()[at++] = point.cast<float>();

  grow(gpu_, capsules_, scene.capsules.size(), Memory::kHost);
  for (std::size_t i = 0; i < scene.capsules.size(); ++i) {
    const SceneCapsule& capsule = scene.capsules[i];
    capsules_.host()[i] = {capsule.a.cast<float>(), capsule.b.cast<float>(),
                           static_cast<float>(capsule.radius_a_m), static_cast<float>(capsule.radius_b_m),
                           capsule.albedo};
  }
}

/// The triangles that the current submission may still draw; at least one.
std::uint32_t Renderer::remainingTriangles() const {
  return options_.max_submission_triangles == 0 ? UINT32_MAX
                                                : options_.max_submission_triangles - submission_triangles_;
}

/// Counts recorded triangles or vertices and divides the submission at the limit. \pre count <=
/// remainingTriangles()
void Renderer::countTriangles(Recorder& recorder, std::uint32_t count) {
  if (options_.max_submission_triangles == 0) return;
  submission_triangles_ += count;
  if (submission_triangles_ < options_.max_submission_triangles) return;
  recorder.divide();
  submission_triangles_ = 0;
}

/// Divides the submission between passes, which is free; within a pass, the image would have to be reloaded.
void Renderer::divideIfLarge(Recorder& recorder) {
  if (submission_triangles_ > options_.max_submission_triangles / 8)
    countTriangles(recorder, remainingTriangles());
}

/// Records the pass, divided into several if it draws more triangles than a submission may have.
void Renderer::drawDivided(Recorder& recorder, RenderPass pass, const std::vector<Draw>& draws) {
  std::vector<Draw> piece;
  std::uint32_t triangles = 0;
  const auto end = [&] {
    render(recorder, pass, piece);
    pass.clear_color.reset();
    pass.clear_depth.reset();
    piece.clear();
    countTriangles(recorder, std::exchange(triangles, 0));
  };
  for (Draw rest : draws) {
    while (rest.indices && rest.vertices / 3 > remainingTriangles() - triangles) {
      Draw part = rest;
      part.vertices = 3 * (remainingTriangles() - triangles);
      rest.first += part.vertices;
      rest.vertices -= part.vertices;
      triangles = remainingTriangles();
      piece.push_back(std::move(part));
      end();
    }
    triangles = std::min(triangles + rest.vertices / 3, remainingTriangles());
    piece.push_back(std::move(rest));
  }
  end();
}

void Renderer::recordDensities(Recorder& recorder, const Scene& scene) {
  recorder.fill(areas_.raw(), 0);
  for (const LitMesh& mesh : lit_meshes_) {
    const RigidTransform place = rigidTransform(mesh.workspace_from_mesh);
    RenderDensityArgs args{};
    args.positions = *mesh.surface.positions;
    args.areas = areas_;
    args.rotation = place.rotation;
    args.translation = place.translation;
    args.edge_m = static_cast<float>(scene.workspace.edge_m);
    args.weight = static_cast<float>(mesh.opacity);
    const auto triangles = static_cast<std::uint32_t>(mesh.surface.triangles->count() / 3);
    for (std::uint32_t first = 0; first < triangles; first += args.triangle_count) {
      args.triangles = {mesh.surface.triangles->at(3 * first).address};
      args.triangle_count = std::min(triangles - first, remainingTriangles());
      recorder.dispatch(pipelines_->density, args, groupsFor(args.triangle_count, kRenderWorkgroup));
      countTriangles(recorder, args.triangle_count);
    }
  }
  constexpr std::uint32_t kCoarsest = kDensityCells / 4;
  recorder.dispatch(pipelines_->density_levels, RenderLevelArgs{areas_, densities_},
                    groupsFor(kCoarsest * kCoarsest * kCoarsest, kRenderWorkgroup));
}

RenderMeshArgs Renderer::meshArgs(const LitMesh& mesh, bool from_light) const {
  const Eigen::Matrix4d& clip =
      from_light ? transforms_.light_from_workspace : transforms_.clip_from_workspace;
  const Pose mesh_from_workspace = mesh.workspace_from_mesh.inverse();
  RenderMeshArgs args{};
  args.positions = *mesh.surface.positions;
  args.normals = *mesh.surface.normals;
  if (!from_light) args.lights = {lights_.at(mesh.first_light).address};
  args.clip_from_mesh = (clip * mesh.workspace_from_mesh.matrix()).cast<float>();
  args.eye = Vec3(mesh_from_workspace * transforms_.eye).cast<float>();
  args.key_direction = Vec3(mesh_from_workspace.linear() * transforms_.key_direction).cast<float>();
  args.albedo = mesh.albedo;
  args.opacity = static_cast<float>(mesh.opacity);
  return args;
}

RenderCapsuleArgs Renderer::capsuleArgs(bool from_light) const {
  const Eigen::Matrix4d& clip =
      from_light ? transforms_.light_from_workspace : transforms_.clip_from_workspace;
  return {capsules_, clip.cast<float>(), transforms_.eye.cast<float>(),
          transforms_.key_direction.cast<float>()};
}

void Renderer::recordShadowMap(Recorder& recorder, const Scene& scene) {
  std::vector<Draw> draws;
  for (const LitMesh& mesh : lit_meshes_)
    draws.push_back(drawIndexed(pipelines_->shadow_mesh, meshArgs(mesh, true), *mesh.surface.triangles));
  if (!scene.capsules.empty())
    draws.push_back(draw(pipelines_->shadow_capsules, capsuleArgs(true), kCapsuleVertices,
                         static_cast<std::uint32_t>(scene.capsules.size())));
  if (scene.voxels)
    draws.push_back(drawCounted(pipelines_->shadow_voxels, voxelArgs(scene, true), voxels_->counts.raw()));
  drawDivided(recorder, {.depth = &shadow_image_, .clear_depth = 1.0f}, draws);
  copyToBuffer(recorder, shadow_image_, shadow_map_.raw());
}

void Renderer::recordLights(Recorder& recorder, const Scene& scene) {
  RenderLightArgs args{};
  args.frame = frame_;
  args.shadow_map = shadow_map_;
  args.densities = densities_;
  const bool has_grid = scene.hand && scene.hand->skin && !scene.hand->skin->grid().values.empty();
  const auto light = [&](const Buffer<vec3>& positions, const Buffer<vec3>& normals,
                         const Buffer<VertexLight>& lights, std::size_t first_light) {
    const auto vertices = static_cast<std::uint32_t>(positions.count());
    for (std::uint32_t first = 0; first < vertices; first += args.count) {
      args.positions = {positions.at(first).address};
      args.normals = {normals.at(first).address};
      args.lights = {lights.at(first_light + first).address};
      args.count = std::min(vertices - first, remainingTriangles());
      recorder.dispatch(pipelines_->light, args, groupsFor(args.count, kRenderWorkgroup));
      countTriangles(recorder, args.count);
    }
  };
  for (const LitMesh& mesh : lit_meshes_) {
    const RigidTransform place = rigidTransform(mesh.workspace_from_mesh);
    args.hand_grid = {};
    if (has_grid && !mesh.is_hand) args.hand_grid = scene.hand->skin->gridValues();
    args.rotation = place.rotation;
    args.translation = place.translation;
    args.two_sided = mesh.open;
    args.shows_touch = mesh.shows_touch;
    light(*mesh.surface.positions, *mesh.surface.normals, lights_, mesh.first_light);
  }
  args.hand_grid = {};
  args.two_sided = args.shows_touch = 0;
  args.rotation = mat3::Identity();
  args.translation = vec3::Zero();
  if (scene.voxels) {
    args.positions = voxels_->positions;
    args.normals = voxels_->normals;
    args.lights = {voxels_->lights.at(0).address};
    args.device_count = {voxels_->counts.at(0).address + offsetof(VoxelCounts, instances)};
    args.count = voxels_->capacity;
    recorder.dispatchIndirect(pipelines_->light, args, voxels_->counts.raw(),
                              offsetof(VoxelCounts, groups_x));
    args.device_count = {};
  }
  if (!scene.ground_z_m) return;
  if (has_grid) args.hand_grid = scene.hand->skin->gridValues();
  args.rotation *= kGroundHalf * static_cast<float>(scene.workspace.edge_m);
  args.translation.z() = static_cast<float>(*scene.ground_z_m);
  light(ground_positions_, ground_normals_, ground_lights_, 0);
  const auto side = static_cast<std::uint32_t>(options_.ground_vertices);
  recorder.dispatch(pipelines_->ground_cells, RenderGroundArgs{ground_lights_, ground_triangles_, side},
                    groupsFor((side - 1) * (side - 1), kRenderWorkgroup));
}

void Renderer::addStrokes(std::vector<Draw>& draws, const Scene& scene, bool hidden) const {
  std::size_t own_points_before = 0;
  for (const SceneStrokes& strokes : scene.strokes) {
    RenderStrokeArgs args{};
    args.clip_from_strokes =
        (transforms_.clip_from_workspace * strokes.workspace_from_strokes.matrix()).cast<float>();
    args.eye = Vec3(strokes.workspace_from_strokes.inverse() * transforms_.eye).cast<float>();
    args.viewport = vec2(static_cast<float>(options_.width), static_cast<float>(options_.height));
    std::size_t ends = strokes.host_points.size();
    if (strokes.points) {
      args.points = *strokes.points;
      ends = strokes.points->count();
      if (strokes.indices) {
        args.indices = *strokes.indices;
        ends = strokes.indices->count();
      }
    } else {
      if (ends > 0) args.points = {stroke_points_.at(own_points_before).address};
      own_points_before += ends;
    }
    const auto quads = static_cast<std::uint32_t>(strokes.dots ? ends : ends / 2);
    if (quads == 0 || (hidden && strokes.hidden <= 0)) continue;
    args.color << strokes.color, hidden ? static_cast<float>(strokes.hidden) : 1.0f;
    args.width = static_cast<float>(strokes.width_px * options_.height / 720);
    const auto& pipeline = hidden ? (strokes.dots ? pipelines_->hidden_dots : pipelines_->hidden_lines)
                                  : (strokes.dots ? pipelines_->dots : pipelines_->lines);
    draws.push_back(draw(pipeline, args, 6 * quads));
  }
}

RenderBackdropArgs Renderer::backdropArgs(const Scene& scene) const {
  RenderBackdropArgs args{};
  if (scene.ground_z_m) {
    const double half_m = kGroundHalf * scene.workspace.edge_m;
    const Eigen::Affine3d workspace_from_ground =
        Eigen::Translation3d(0, 0, *scene.ground_z_m) * Eigen::Scaling(half_m, half_m, 1.0);
    args.positions = ground_positions_;
    args.lights = {ground_lights_.at(0).address};
    args.clip_from_ground = (transforms_.clip_from_workspace * workspace_from_ground.matrix()).cast<float>();
  }
  args.top = scene.backdrop_top;
  args.bottom = scene.backdrop_bottom;
  args.viewport = vec2(static_cast<float>(options_.width), static_cast<float>(options_.height));
  return args;
}

/// Fills color_ with the backdrop. The backdrop depends only on its colours, so it is drawn once and then
/// copied, which takes a tenth of the time on a software device.
void Renderer::recordBackdrop(Recorder& recorder, const Scene& scene) {
  if (scene.backdrop_top != backdrop_top_ || scene.backdrop_bottom != backdrop_bottom_) {
    const RenderPass pass{
        .color = &backdrop_, .depth = &depth_, .clear_color = vec4(0, 0, 0, 1), .clear_depth = 1.0f};
    render(recorder, pass, {draw(pipelines_->backdrop, backdropArgs(scene), 3)});
    backdrop_top_ = scene.backdrop_top;
    backdrop_bottom_ = scene.backdrop_bottom;
  }
  copyImage(recorder, backdrop_, color_);
}

void Renderer::recordFrame(Recorder& recorder, const Scene& scene) {
  std::vector<Draw> draws;
  // front faces first: they hide most back faces of an open surface, which then fail the depth test early
  for (const auto* side : {&pipelines_->clay, &pipelines_->clay_inside})
    for (const LitMesh& mesh : lit_meshes_)
      if (!mesh.is_hand && (mesh.open || side == &pipelines_->clay))
        draws.push_back(drawIndexed(*side, meshArgs(mesh, false), *mesh.surface.triangles));
  if (scene.voxels)
    draws.push_back(drawCounted(pipelines_->voxels, voxelArgs(scene, false), voxels_->counts.raw()));
  if (!scene.capsules.empty())
    draws.push_back(draw(pipelines_->capsules, capsuleArgs(false), kCapsuleVertices,
                         static_cast<std::uint32_t>(scene.capsules.size())));
  if (scene.ground_z_m)
    draws.push_back(drawIndexed(pipelines_->ground, backdropArgs(scene), ground_triangles_));
  if (options_.multisample) draws.push_back(draw(pipelines_->backdrop, backdropArgs(scene), 3));
  addStrokes(draws, scene, true);
  addStrokes(draws, scene, false);
  // only the hand's nearest surface: its depth first, then its colour
  for (const LitMesh& mesh : lit_meshes_)
    if (mesh.is_hand)
      draws.push_back(drawIndexed(pipelines_->hand_depth, meshArgs(mesh, false), *mesh.surface.triangles));
  for (const LitMesh& mesh : lit_meshes_)
    if (mesh.is_hand)
      draws.push_back(drawIndexed(mesh.is_forearm ? pipelines_->forearm : pipelines_->skin,
                                  meshArgs(mesh, false), *mesh.surface.triangles));
  RenderPass pass{.color = &color_, .depth = &depth_, .clear_depth = 1.0f};
  if (options_.multisample) {
    pass.resolve = &resolved_;
    pass.clear_color = vec4(0, 0, 0, 1);
  } else {
    recordBackdrop(recorder, scene);
  }
  drawDivided(recorder, pass, draws);
  if (options_.readback) copyToBuffer(recorder, image(), pixels_.raw());
}

}  // namespace airclay
