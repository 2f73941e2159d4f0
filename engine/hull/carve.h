// SPDX-License-Identifier: MIT
// The voxel model (the paper's fig. 1): the visual hull, which is the intersection of the silhouettes'
// back-projections (Laurentini 1994), carved coarse to fine.
//
// A voxel is occupied if at least two cameras see its centre and every camera that sees it has it in its
// silhouette. Cameras that do not see it are ignored.
#pragma once

#include "engine/camera/gpu_rig.h"
#include "engine/gpu/kernel.h"
#include "engine/gpu/recorder.h"
#include "shaders/hull/carve_io.h"

namespace airclay {

inline constexpr int kMinVoxels = 32, kMaxVoxels = 512;  ///< along the workspace's edge

/// \throw Error unless kMinVoxels <= voxels <= kMaxVoxels.
void checkVoxels(int voxels);

/// Occupancy on the CPU, one byte per voxel (0 or 1), x fastest.
struct VoxelGrid {
  int voxels = 0;  ///< along an edge
  std::vector<std::uint8_t> occupied;
  std::uint8_t at(int x, int y, int z) const {
    return occupied[std::size_t(x) +
                    std::size_t(voxels) * (std::size_t(y) + std::size_t(voxels) * std::size_t(z))];
  }
};

/// A voxel's centre, world, metres.
Vec3 voxelCenter(const Workspace& workspace, int voxels, int x, int y, int z);

struct HullStats {
  std::size_t occupied = 0;      ///< voxels
  Vec3 centroid = Vec3::Zero();  ///< of the occupied voxels, world, metres; zero if there are none
};

/// Carves on the GPU. The model stays in device memory, in the layout of carve_io.h.
class Carver {
 public:
  Carver(Gpu& gpu, const GpuRig& rig, int voxels);

  /// Records the carving of `masks` (GpuRig's layout). The cost is proportional to the hull's surface.
  /// Ignores the cameras whose bits are set in `missing_cameras`.
  void record(Recorder& recorder, const Buffer<std::uint32_t>& masks, std::uint32_t missing_cameras = 0);

  int voxels() const { return voxels_; }
  double voxelMetres() const { return rig_.rig().workspace.edge_m / voxels_; }
  std::uint32_t bricksEdge() const { return bricks_edge_; }
  const Buffer<std::uint32_t>& brickStates() const { return brick_states_; }
  const Buffer<std::uint32_t>& words() const { return words_; }
  const Buffer<HullSums>& sums() const { return sums_; }
  /// Volume and centroid. \pre the recorded work is done
  HullStats stats() const;
  /// Copies the model to the CPU. \pre the recorded work is done
  VoxelGrid download() const;

 private:
  void recordBlocks(Recorder& recorder, const Kernel<CarveBlockArgs>& kernel, int level,
                    std::uint32_t camera_bits);

  Gpu& gpu_;
  const GpuRig& rig_;
  int voxels_;
  std::uint32_t bricks_edge_;
  std::uint32_t workgroup_;  ///< invocations
  Kernel<CarveTileArgs> tile_kernel_;
  Kernel<CarveBlockArgs> top_blocks_, brick_blocks_, small_blocks_;
  Kernel<CarveVoxelArgs> voxel_kernel_;
  Buffer<std::uint64_t> tiles_;
  Buffer<std::uint32_t> brick_states_, words_;
  Buffer<MixedCount> mixed_counts_;                    ///< of blocks of 32, 8 and 4 voxels
  std::array<Buffer<MixedBlock>, kMixedSizes> mixed_;  ///< these blocks
  Buffer<HullSums> sums_;
};

/// The visual hull of one frame, carved on the GPU and copied to the CPU. For many frames, use Carver, which
/// keeps its buffers. \pre one mask per camera, in the rig's order and of the cameras' sizes
/// \throw Error unless kMinVoxels <= voxels <= kMaxVoxels.
VoxelGrid carve(Gpu& gpu, const Rig& rig, const std::vector<Silhouette>& masks, int voxels = 128);

/// The reference implementation: voxel by voxel, in double precision.
VoxelGrid carveReference(const Rig& rig, const std::vector<Silhouette>& masks, int voxels);

/// Whether the point projects, in any camera, to within `pixels` of a silhouette's edge or an image's border,
/// where single and double precision may round to different pixels.
bool isEdgePoint(const Rig& rig, const std::vector<Silhouette>& masks, const Vec3& point_in_world,
                 double pixels);

/// isEdgePoint() of every voxel's centre, one byte per voxel.
std::vector<std::uint8_t> edgeVoxels(const Rig& rig, const std::vector<Silhouette>& masks, int voxels,
                                     double pixels);

/// The largest difference, in pixels, of a projected voxel centre in single and double precision, for images
/// of several hundred pixels.
inline constexpr double kEdgePixels = 0.01;

/// The statistics of a grid, in double precision.
HullStats hullStats(const VoxelGrid& grid, const Workspace& workspace);

}  // namespace airclay
