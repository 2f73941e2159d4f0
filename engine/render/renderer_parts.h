// SPDX-License-Identifier: MIT
// Internals of the renderer; included only by its sources.
#pragma once

#include "engine/gpu/kernel.h"
#include "engine/render/renderer.h"
#include "shaders/render/renderer_voxels_io.h"

namespace airclay {

/// The format of the image that is drawn to.
struct TargetFormat {
  ImageKind kind = ImageKind::kColor;
  std::uint32_t samples = 1;
};

/// All compute and graphics pipelines.
struct Renderer::Pipelines {
  Kernel<RenderDensityArgs> density;
  Kernel<RenderLevelArgs> density_levels;
  Kernel<RenderLightArgs> light;
  Kernel<RenderGroundArgs> ground_cells;
  Kernel<VoxelListArgs> count_voxels, list_voxels;
  Kernel<VoxelScanArgs> scan_voxels;
  GraphicsPipeline<RenderMeshArgs> shadow_mesh, clay, clay_inside, hand_depth, skin, forearm;
  GraphicsPipeline<RenderCapsuleArgs> shadow_capsules, capsules;
  GraphicsPipeline<RenderVoxelArgs> shadow_voxels, voxels;
  GraphicsPipeline<RenderBackdropArgs> ground, backdrop;
  GraphicsPipeline<RenderStrokeArgs> lines, dots, hidden_lines, hidden_dots;

  Pipelines(Gpu& gpu, const TargetFormat& target);
};

/// A mesh and its offset in the buffer of vertex lights.
struct Renderer::LitMesh {
  SurfaceBuffers surface;
  Pose workspace_from_mesh = Pose::Identity();
  vec3 albedo = vec3::Zero();
  double opacity = 1;
  bool open = false, shows_touch = false, is_hand = false, is_forearm = false;
  std::uint32_t first_light = 0;
};

/// The list of the model's surface voxels.
struct Renderer::Voxels {
  int voxels = 0;  ///< along the workspace's edge
  std::uint32_t bricks = 0, capacity = 0;
  Buffer<std::uint32_t> brick_counts, brick_firsts;
  Buffer<VoxelCounts> counts;
  Buffer<vec3> positions, normals;
  Buffer<VertexLight> lights;

  Voxels(Gpu& gpu, const Carver& carver);
};

}  // namespace airclay
