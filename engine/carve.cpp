// SPDX-License-Identifier: MIT
#include "engine/carve.h"

#include "engine/error.h"
#include "shaders/carve_blocks.comp.h"
#include "shaders/carve_summary.comp.h"
#include "shaders/carve_tiles.comp.h"
#include "shaders/carve_total.comp.h"
#include "shaders/carve_voxels.comp.h"

namespace airclay {
namespace {

std::uint32_t ceilDivide(std::uint32_t a, std::uint32_t b) {
  return (a + b - 1) / b;
}
std::uint32_t cube(std::uint32_t x) {
  return x * x * x;
}

constexpr std::uint32_t kBlockEdges[3] = {kTopVoxels, kBrickVoxels, kBlockVoxels};
/// Blocks of a level that one invocation classes: all along x that a parent has, but for the topmost.
constexpr std::uint32_t kRuns[3] = {4, 4, 2};

/// 16: the 4,096 bricks of 128³ make four workgroups; the sums of a workgroup's share fit 32 bits.
constexpr std::uint32_t kBricksPerInvocation = 16;

}  // namespace

void checkVoxels(int voxels) {
  if (voxels < kMinVoxels || voxels > kMaxVoxels)
    throw Error("--voxels " + std::to_string(voxels) + " is out of range; give " +
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
      tile_kernel_(gpu, "carve_tiles", carve_tiles_comp, {kCarveWorkgroup}),
      top_blocks_(gpu, "carve_blocks_32", carve_blocks_comp,
                  {kCarveWorkgroup, kTopVoxels, kRuns[0], rig.lensKinds()}),
      brick_blocks_(gpu, "carve_blocks_8", carve_blocks_comp,
                    {kCarveWorkgroup, kBrickVoxels, kRuns[1], rig.lensKinds()}),
      small_blocks_(gpu, "carve_blocks_4", carve_blocks_comp,
                    {kCarveWorkgroup, kBlockVoxels, kRuns[2], rig.lensKinds()}),
      voxel_kernel_(gpu, "carve_voxels", carve_voxels_comp, {kCarveWorkgroup, rig.lensKinds()}),
      summary_kernel_(gpu, "carve_summary", carve_summary_comp, {kCarveWorkgroup}),
      total_kernel_(gpu, "carve_total", carve_total_comp),
      tiles_(gpu, rig.tileEntries()),
      brick_states_(gpu, cube(bricks_edge_)),
      words_(gpu, std::size_t(cube(bricks_edge_)) * kBrickWords) {
  for (std::size_t level = 0; level < 3; ++level) {
    mixed_[level] =
        Buffer<MixedBlock>(gpu, cube(ceilDivide(static_cast<std::uint32_t>(voxels), kBlockEdges[level])));
    mixed_count_[level] = Buffer<MixedCount>(gpu, 1);
  }
  bricks_per_invocation_ = kBricksPerInvocation;
  summary_groups_ = ceilDivide(cube(bricks_edge_), kCarveWorkgroup * bricks_per_invocation_);
  partial_sums_ = Buffer<std::uint64_t>(gpu, 4 * std::size_t(summary_groups_));
  summary_ = Buffer<HullSummary>(gpu, 1, Memory::kHost);
}

void Carver::recordBlocks(Recorder& recorder, const Kernel<CarveBlockArgs>& kernel, int level) {
  const auto at = static_cast<std::size_t>(level);
  CarveBlockArgs args{};
  args.cameras = rig_.cameras();
  args.tiles = tiles_;
  if (level > 0) {
    args.parents = mixed_[at - 1];
    args.parent_count = mixed_count_[at - 1];
  }
  args.mixed = mixed_[at];
  args.mixed_count = mixed_count_[at];
  args.brick_states = brick_states_;
  args.words = words_;
  args.camera_count = rig_.cameraCount();
  args.voxels = static_cast<std::uint32_t>(voxels_);
  args.voxel_m = static_cast<float>(voxelMetres());
  args.children_edge =
      level == 0 ? ceilDivide(args.voxels, kTopVoxels) : kBlockEdges[at - 1] / kBlockEdges[at];
  args.runs_edge = ceilDivide(args.children_edge, kRuns[at]);
  // the next level takes a run an invocation, the voxels' kernel a block
  args.next_invocations = level == 2 ? 1 : cube(kBlockEdges[at] / kBlockEdges[at + 1]) / kRuns[at + 1];
  if (level == 0)
    recorder.dispatch(kernel, args,
                      groupsFor(args.runs_edge * args.children_edge * args.children_edge, kCarveWorkgroup));
  else
    recorder.dispatchIndirect(kernel, args, mixed_count_[at - 1].raw(), 0);
}

void Carver::record(Recorder& recorder, const Buffer<std::uint32_t>& masks) {
  const MixedCount none{0, 1, 1, 0};
  for (Buffer<MixedCount>& count : mixed_count_) recorder.update(count.raw(), &none, sizeof none);

  CarveTileArgs tiles{};
  tiles.cameras = rig_.cameras();
  tiles.masks.address = masks.raw().address();  // read as pairs
  tiles.tiles = tiles_;
  recorder.dispatch(tile_kernel_, tiles, groupsFor(rig_.maxTileEntries(), kCarveWorkgroup),
                    rig_.cameraCount());

  recordBlocks(recorder, top_blocks_, 0);
  recordBlocks(recorder, brick_blocks_, 1);
  recordBlocks(recorder, small_blocks_, 2);

  CarveVoxelArgs voxel{};
  voxel.cameras = rig_.cameras();
  voxel.masks = masks;
  voxel.blocks = mixed_[2];
  voxel.block_count = mixed_count_[2];
  voxel.words = words_;
  voxel.voxels = static_cast<std::uint32_t>(voxels_);
  voxel.voxel_m = static_cast<float>(voxelMetres());
  recorder.dispatchIndirect(voxel_kernel_, voxel, mixed_count_[2].raw(), 0);

  CarveSummaryArgs summary{};
  summary.brick_states = brick_states_;
  summary.words = words_;
  summary.partial_sums = partial_sums_;
  summary.brick_count = cube(bricks_edge_);
  summary.bricks_edge = bricks_edge_;
  summary.bricks_per_invocation = bricks_per_invocation_;
  recorder.dispatch(summary_kernel_, summary, summary_groups_);

  CarveTotalArgs total{};
  total.partial_sums = partial_sums_;
  total.summary = summary_;
  total.partial_count = summary_groups_;
  total.voxels = static_cast<std::uint32_t>(voxels_);
  total.voxel_m = static_cast<float>(voxelMetres());
  recorder.dispatch(total_kernel_, total, 1);
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

}  // namespace airclay
