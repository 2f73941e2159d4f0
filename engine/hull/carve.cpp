// SPDX-License-Identifier: MIT
#include "engine/hull/carve.h"

#include <algorithm>

#include "engine/core/error.h"
#include "shaders/hull/carve_blocks.comp.h"
#include "shaders/hull/carve_tiles.comp.h"
#include "shaders/hull/carve_voxels.comp.h"

namespace airclay {
namespace {

std::uint32_t ceilDivide(std::uint32_t a, std::uint32_t b) {
  return (a + b - 1) / b;
}
std::uint32_t cube(std::uint32_t x) {
  return x * x * x;
}

constexpr std::uint32_t kBlockEdges[kMixedSizes] = {kTopVoxels, kBrickVoxels, kBlockVoxels};
/// Blocks of a level that one invocation classifies: a parent's blocks along x, except at the top level.
constexpr std::uint32_t kRuns[kMixedSizes] = {4, 4, 2};

/// Up to this resolution a workgroup may be one subgroup: with 512³ voxels, the 4³ blocks would exceed the
/// 65,535 workgroups of a dispatch.
constexpr int kFineGrainedVoxels = 256;

/// Invocations that load a camera together (load_camera.glsl's kLanes): with 8, a camera takes three loads.
std::uint32_t lanes(const Gpu& gpu) {
  return std::min(gpu.subgroupSize(), 8u);
}

}  // namespace

void checkVoxels(int voxels) {
  if (voxels < kMinVoxels || voxels > kMaxVoxels)
    throw Error("--voxels " + std::to_string(voxels) + " is out of range; expected " +
                std::to_string(kMinVoxels) + " to " + std::to_string(kMaxVoxels) +
                " voxels along the workspace's edge");
}

Vec3 voxelCenter(const Workspace& workspace, int voxels, int x, int y, int z) {
  const double voxel_m = workspace.edge_m / voxels;
  return workspace.center + voxel_m * (Vec3(x, y, z) + Vec3::Constant(0.5 - 0.5 * voxels));
}

Carver::Carver(Gpu& gpu, const GpuRig& rig, int voxels)
    : gpu_(gpu),
      rig_(rig),
      voxels_((checkVoxels(voxels), voxels)),
      bricks_edge_(ceilDivide(static_cast<std::uint32_t>(voxels), kBrickVoxels)),
      workgroup_(gpu.isCpu() && voxels <= kFineGrainedVoxels ? std::min(gpu.subgroupSize(), kCarveWorkgroup)
                                                             : kCarveWorkgroup),
      tile_kernel_(gpu, "carve_tiles", carve_tiles_comp, {workgroup_, rig.sameSize()[0], rig.sameSize()[1]}),
      top_blocks_(gpu, "carve_blocks_32", carve_blocks_comp,
                  {workgroup_, kTopVoxels, kRuns[0], rig.lensKinds(), lanes(gpu)}),
      brick_blocks_(gpu, "carve_blocks_8", carve_blocks_comp,
                    {workgroup_, kBrickVoxels, kRuns[1], rig.lensKinds(), lanes(gpu)}),
      small_blocks_(gpu, "carve_blocks_4", carve_blocks_comp,
                    {workgroup_, kBlockVoxels, kRuns[2], rig.lensKinds(), lanes(gpu)}),
      voxel_kernel_(gpu, "carve_voxels", carve_voxels_comp, {workgroup_, rig.lensKinds(), lanes(gpu)}),
      tiles_(gpu, rig.tileEntries()),
      brick_states_(gpu, cube(bricks_edge_)),
      words_(gpu, std::size_t(cube(bricks_edge_)) * kBrickWords),
      mixed_counts_(gpu, kMixedSizes),
      sums_(gpu, 1, Memory::kHost) {
  for (std::size_t level = 0; level < kMixedSizes; ++level)
    mixed_[level] =
        Buffer<MixedBlock>(gpu, cube(ceilDivide(static_cast<std::uint32_t>(voxels), kBlockEdges[level])));
}

void Carver::recordBlocks(Recorder& recorder, const Kernel<CarveBlockArgs>& kernel, int level,
                          std::uint32_t camera_bits) {
  const auto at = static_cast<std::size_t>(level);
  CarveBlockArgs args{};
  args.cameras = rig_.cameras();
  args.tiles = tiles_;
  if (level > 0) {
    args.parents = mixed_[at - 1];
    args.parent_count.address = mixed_counts_.at(at - 1).address;
  }
  args.mixed = mixed_[at];
  args.mixed_count = mixed_counts_.at(at);
  args.brick_states = brick_states_;
  args.words = words_;
  args.sums.address = sums_.raw().address();
  args.camera_bits = camera_bits;
  args.voxels = static_cast<std::uint32_t>(voxels_);
  args.voxel_m = static_cast<float>(voxelMetres());
  args.children_edge =
      level == 0 ? ceilDivide(args.voxels, kTopVoxels) : kBlockEdges[at - 1] / kBlockEdges[at];
  args.runs_edge = ceilDivide(args.children_edge, kRuns[at]);
  // the next level takes one run per invocation, the voxel kernel one block
  args.next_invocations = level == 2 ? 1 : cube(kBlockEdges[at] / kBlockEdges[at + 1]) / kRuns[at + 1];
  if (level == 0)
    recorder.dispatch(kernel, args,
                      groupsFor(args.runs_edge * args.children_edge * args.children_edge, workgroup_));
  else
    recorder.dispatchIndirect(kernel, args, mixed_counts_.raw(), (at - 1) * sizeof(MixedCount));
}

void Carver::record(Recorder& recorder, const Buffer<std::uint32_t>& masks, std::uint32_t missing_cameras) {
  CarveTileArgs tiles{};
  tiles.cameras = rig_.cameras();
  tiles.masks.address = masks.raw().address();  // read as pairs
  tiles.tiles = tiles_;
  tiles.mixed_counts = mixed_counts_;
  tiles.sums.address = sums_.raw().address();
  recorder.dispatch(tile_kernel_, tiles, groupsFor(rig_.maxBands(), workgroup_), rig_.cameraCount());

  const std::uint32_t all = rig_.cameraCount() == 32 ? ~0u : (1u << rig_.cameraCount()) - 1;
  recordBlocks(recorder, top_blocks_, 0, all & ~missing_cameras);
  recordBlocks(recorder, brick_blocks_, 1,
               0);  // lower levels test the cameras that their parents left undecided
  recordBlocks(recorder, small_blocks_, 2, 0);

  CarveVoxelArgs voxel{};
  voxel.cameras = rig_.cameras();
  voxel.masks = masks;
  voxel.blocks = mixed_[2];
  voxel.block_count.address = mixed_counts_.at(2).address;
  voxel.words = words_;
  voxel.sums.address = sums_.raw().address();
  voxel.voxels = static_cast<std::uint32_t>(voxels_);
  voxel.voxel_m = static_cast<float>(voxelMetres());
  recorder.dispatchIndirect(voxel_kernel_, voxel, mixed_counts_.raw(), 2 * sizeof(MixedCount));
}

HullStats Carver::stats() const {
  const HullSums& sums = sums_.host()[0];
  HullStats stats;
  stats.occupied = sums.occupied;
  if (sums.occupied == 0) return stats;
  const Vec3 index_sum(double(sums.index_sums[0]), double(sums.index_sums[1]), double(sums.index_sums[2]));
  const Vec3 index = index_sum / double(sums.occupied) + Vec3::Constant(0.5 - 0.5 * voxels_);
  stats.centroid = rig_.rig().workspace.center + voxelMetres() * index;
  return stats;
}

VoxelGrid Carver::download() const {
  const std::vector<std::uint32_t> states = brick_states_.download();
  const std::vector<std::uint32_t> words = words_.download();
  const auto n = static_cast<std::uint32_t>(voxels_);
  VoxelGrid grid{voxels_, std::vector<std::uint8_t>(std::size_t(n) * n * n)};
  std::size_t at = 0;
  for (std::uint32_t z = 0; z < n; ++z)
    for (std::uint32_t y = 0; y < n; ++y)
      for (std::uint32_t x = 0; x < n; ++x, ++at) {
        const std::uint32_t brick = x / 8 + bricks_edge_ * (y / 8 + bricks_edge_ * (z / 8));
        if (states[brick] != kBrickMixed) {
          grid.occupied[at] = states[brick] == kBrickFull;
          continue;
        }
        const std::uint32_t block = (x / 4 & 1) + 2 * (y / 4 & 1) + 4 * (z / 4 & 1);
        const std::uint32_t bit = (x & 3) + 4 * (y & 3) + 16 * (z & 3);
        grid.occupied[at] = words[std::size_t(brick) * kBrickWords + 2 * block + bit / 32] >> (bit % 32) & 1;
      }
  return grid;
}

VoxelGrid carve(Gpu& gpu, const Rig& rig, const std::vector<Silhouette>& masks, int voxels) {
  const GpuRig gpu_rig(gpu, rig);
  Carver carver(gpu, gpu_rig, voxels);
  std::vector<std::uint32_t> packed(gpu_rig.maskWords());
  gpu_rig.pack(masks, packed);
  const Buffer<std::uint32_t> mask_words(gpu, packed);
  Recorder recorder(gpu);
  recorder.begin();
  carver.record(recorder, mask_words);
  recorder.submitAndWait();
  return carver.download();
}

}  // namespace airclay
