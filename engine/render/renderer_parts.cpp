// SPDX-License-Identifier: MIT
#include "engine/render/renderer_parts.h"

#include "engine/hull/carve.h"
#include "shaders/render/render_backdrop.frag.h"
#include "shaders/render/render_backdrop.vert.h"
#include "shaders/render/render_capsules.frag.h"
#include "shaders/render/render_capsules.vert.h"
#include "shaders/render/render_clay.frag.h"
#include "shaders/render/render_density.comp.h"
#include "shaders/render/render_density_levels.comp.h"
#include "shaders/render/render_depth.vert.h"
#include "shaders/render/render_ground.frag.h"
#include "shaders/render/render_ground.vert.h"
#include "shaders/render/render_ground_cells.comp.h"
#include "shaders/render/render_light.comp.h"
#include "shaders/render/render_mesh.vert.h"
#include "shaders/render/render_skin.frag.h"
#include "shaders/render/render_strokes.frag.h"
#include "shaders/render/render_strokes.vert.h"
#include "shaders/render/render_voxel_list.comp.h"
#include "shaders/render/render_voxel_scan.comp.h"
#include "shaders/render/render_voxels.frag.h"
#include "shaders/render/render_voxels.vert.h"

namespace airclay {
namespace {

GraphicsOptions solid(const TargetFormat& target) {
  GraphicsOptions options;
  options.color_kind = target.kind;
  options.samples = target.samples;
  return options;
}

/// Only front faces, or only back faces.
GraphicsOptions oneSide(const TargetFormat& target, VkCullModeFlags culled) {
  GraphicsOptions options = solid(target);
  options.cull = culled;
  return options;
}

/// A depth map from the light's view.
GraphicsOptions shadow() {
  GraphicsOptions options;
  options.has_color = false;
  options.samples = 1;
  return options;
}

GraphicsOptions blended(const TargetFormat& target, std::uint32_t constant) {
  GraphicsOptions options = solid(target);
  options.blend = Blend::kAlpha;
  options.constants = {constant};
  return options;
}

/// Depth only. For closed bodies, whose back faces are never the nearest surface.
GraphicsOptions depthOnly(const TargetFormat& target) {
  GraphicsOptions options = solid(target);
  options.blend = Blend::kDepthOnly;
  options.cull = VK_CULL_MODE_BACK_BIT;
  return options;
}

/// Drawn after depthOnly(), which already hides the back faces.
GraphicsOptions skinOptions(const TargetFormat& target, bool fades) {
  GraphicsOptions options = blended(target, fades ? 1 : 0);
  options.cull = VK_CULL_MODE_BACK_BIT;
  options.depth_write = false;
  return options;
}

GraphicsOptions strokes(const TargetFormat& target, bool dots, bool hidden) {
  GraphicsOptions options = blended(target, dots ? 1 : 0);
  options.depth_test = !hidden;
  options.depth_write = false;  // the soft edges must not occlude what is behind them
  return options;
}

/// The most surface voxels that are drawn; the rest is omitted. A cube has 6 N², a hand at N = 128 about N².
std::uint32_t voxelCapacity(int voxels) {
  const auto n = static_cast<std::uint32_t>(voxels);
  return 8 * n * n;
}

}  // namespace

Renderer::Pipelines::Pipelines(Gpu& gpu, const TargetFormat& target)
    : density(gpu, "render_density", render_density_comp, {kRenderWorkgroup}),
      density_levels(gpu, "render_density_levels", render_density_levels_comp, {kRenderWorkgroup}),
      light(gpu, "render_light", render_light_comp, {kRenderWorkgroup}),
      ground_cells(gpu, "render_ground_cells", render_ground_cells_comp, {kRenderWorkgroup}),
      count_voxels(gpu, "render_voxel_count", render_voxel_list_comp, {kRenderWorkgroup, 0}),
      list_voxels(gpu, "render_voxel_list", render_voxel_list_comp, {kRenderWorkgroup, 1}),
      scan_voxels(gpu, "render_voxel_scan", render_voxel_scan_comp),
      shadow_mesh(gpu, "shadow of meshes", {render_depth_vert, {}}, shadow()),
      clay(gpu, "clay", {render_mesh_vert, render_clay_frag}, oneSide(target, VK_CULL_MODE_BACK_BIT)),
      clay_inside(gpu, "clay's inside", {render_mesh_vert, render_clay_frag},
                  oneSide(target, VK_CULL_MODE_FRONT_BIT)),
      hand_depth(gpu, "hand's depth", {render_depth_vert, {}}, depthOnly(target)),
      skin(gpu, "hand", {render_mesh_vert, render_skin_frag}, skinOptions(target, false)),
      forearm(gpu, "forearm", {render_mesh_vert, render_skin_frag}, skinOptions(target, true)),
      shadow_capsules(gpu, "shadow of capsules", {render_capsules_vert, {}}, shadow()),
      capsules(gpu, "capsules", {render_capsules_vert, render_capsules_frag}, solid(target)),
      shadow_voxels(gpu, "shadow of voxels", {render_voxels_vert, {}}, shadow()),
      voxels(gpu, "voxels", {render_voxels_vert, render_voxels_frag}, solid(target)),
      ground(gpu, "ground", {render_ground_vert, render_ground_frag}, solid(target)),
      backdrop(gpu, "backdrop", {render_backdrop_vert, render_backdrop_frag}, solid(target)),
      lines(gpu, "lines", {render_strokes_vert, render_strokes_frag}, strokes(target, false, false)),
      dots(gpu, "dots", {render_strokes_vert, render_strokes_frag}, strokes(target, true, false)),
      hidden_lines(gpu, "hidden lines", {render_strokes_vert, render_strokes_frag},
                   strokes(target, false, true)),
      hidden_dots(gpu, "hidden dots", {render_strokes_vert, render_strokes_frag},
                  strokes(target, true, true)) {}

Renderer::Voxels::Voxels(Gpu& gpu, const Carver& carver)
    : voxels(carver.voxels()),
      bricks(carver.bricksEdge() * carver.bricksEdge() * carver.bricksEdge()),
      capacity(voxelCapacity(carver.voxels())),
      brick_counts(gpu, bricks),
      brick_firsts(gpu, bricks),
      counts(gpu, 1),
      positions(gpu, capacity),
      normals(gpu, capacity),
      lights(gpu, capacity) {}

RenderVoxelArgs Renderer::voxelArgs(const Scene& scene, bool from_light) const {
  RenderVoxelArgs args{};
  args.positions = voxels_->positions;
  if (!from_light) args.lights = {voxels_->lights.at(0).address};
  args.clip_from_workspace =
      (from_light ? transforms_.light_from_workspace : transforms_.clip_from_workspace).cast<float>();
  // a light at a great distance
  args.eye = (from_light ? Vec3(1e3 * transforms_.key_direction) : transforms_.eye).cast<float>();
  args.key_direction = transforms_.key_direction.cast<float>();
  args.albedo = scene.voxel_albedo;
  args.voxel_m = static_cast<float>(scene.voxels->voxelMetres());
  return args;
}

void Renderer::recordVoxelList(Recorder& recorder, const Scene& scene) {
  const std::uint32_t groups = groupsFor(voxels_->bricks, kRenderWorkgroup);
  VoxelListArgs list{};
  list.brick_states = scene.voxels->brickStates();
  list.words = scene.voxels->words();
  list.counts = voxels_->brick_counts;
  list.voxels = static_cast<std::uint32_t>(scene.voxels->voxels());
  list.bricks_edge = scene.voxels->bricksEdge();
  list.voxel_m = static_cast<float>(scene.voxels->voxelMetres());
  list.capacity = voxels_->capacity;
  recorder.dispatch(pipelines_->count_voxels, list, groups);

  VoxelScanArgs scan{};
  scan.counts = voxels_->brick_counts;
  scan.firsts = voxels_->brick_firsts;
  scan.totals = voxels_->counts;
  scan.brick_count = voxels_->bricks;
  scan.capacity = voxels_->capacity;
  recorder.dispatch(pipelines_->scan_voxels, scan, 1);

  list.counts = {};
  list.firsts = voxels_->brick_firsts;
  list.positions = voxels_->positions;
  list.normals = voxels_->normals;
  recorder.dispatch(pipelines_->list_voxels, list, groups);
}

std::uint32_t Renderer::drawnVoxelCount() const {
  return voxels_ ? voxels_->counts.download()[0].instances : 0;
}

}  // namespace airclay
