// SPDX-License-Identifier: MIT
// The voxel model (the paper's fig. 1): the visual hull, that is the intersection of the silhouettes'
// back-projections (Laurentini 1994), carved coarse to fine.
//
// A voxel is occupied when at least two cameras see its centre and it lies in the silhouette of every camera
// that sees it. A camera that doesn't see it has no say.
#pragma once

#include "engine/camera/gpu_rig.h"
#include "engine/gpu/kernel.h"
#include "engine/gpu/recorder.h"
#include "shaders/hull/carve_io.h"

namespace airclay {

inline constexpr int kMinVoxels = 32, kMaxVoxels = 512;  ///< along the workspace's edge

/// \throw Error unless kMinVoxels <= voxels <= kMaxVoxels.
void checkVoxels(int voxels);

/// Occupancy on the CPU, one byte a voxel (0 or 1), x fastest.
struct VoxelGrid {
  int voxels = 0;  ///< along an edge
  std::vector<std::uint8_t> occupied;
  std::uint8_t at(int x, int y, int z) const {
    return occupied[std::size_t(x) +
                    std::size_t(voxels) * (std::size_t(y) + std::size_t(voxels) * std::size_t(z))];
  }
};

/// A voxel's centre in the world.
Vec3 voxelCenter(const Workspace& workspace, int voxels, int x, int y, int z);

struct HullFigures {
  std::size_t occupied = 0;      ///< voxels
  Vec3 centroid = Vec3::Zero();  ///< their centre of gravity in the world; zero when there are none
};

/// Carves on the GPU. The model stays there; see carve_io.h for its layout.
class Carver {
 public:
  Carver(Gpu& gpu, const GpuRig& rig, int voxels);

  /// Records the carving of `masks` (GpuRig's layout). Work is proportional to the hull's surface. Cameras
  /// whose bits are in `absent` have no say.
  void record(Recorder& recorder, const Buffer<std::uint32_t>& masks, std::uint32_t missing_cameras = 0);

  int voxels() const { return voxels_; }
  double voxelMetres() const { return rig_.rig().workspace.edge_m / voxels_; }
  std::uint32_t bricksEdge() const { return bricks_edge_; }
  const Buffer<std::uint32_t>& brickStates() const { return brick_states_; }
  const Buffer<std::uint32_t>& words() const { return words_; }
  const Buffer<HullSums>& sums() const { return sums_; }
  /// Volume and centre of gravity. \pre the recorded work is done
  HullFigures figures() const;
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

/// The visual hull of one frame, carved on the GPU and copied to the CPU. For many frames, Carver keeps its
/// buffers. \pre one mask per camera, in the rig's order and of the cameras' sizes
/// \throw Error unless kMinVoxels <= voxels <= kMaxVoxels.
VoxelGrid carve(Gpu& gpu, const Rig& rig, const std::vector<Mask>& masks, int voxels = 128);

/// The reference: every voxel by itself, in double precision.
VoxelGrid carveReference(const Rig& rig, const std::vector<Mask>& masks, int voxels);

/// Whether a camera's projection of the point falls within `pixels` of a pixel of the other kind or of a
/// image's border: there float and double may round to different pixels.
bool isEdgePoint(const Rig& rig, const std::vector<Mask>& masks, const Vec3& point_in_world, double pixels);

/// The voxels whose centre isEdgePoint(). One byte a voxel.
std::vector<std::uint8_t> edgeVoxels(const Rig& rig, const std::vector<Mask>& masks, int voxels,
                                     double pixels);

/// Float and double put a voxel's centre at most this far apart in an image of some hundred pixels.
inline constexpr double kEdgePixels = 0.01;

/// The figures of a grid: every voxel by itself, in double precision.
HullFigures hullFigures(const VoxelGrid& grid, const Workspace& workspace);

}  // namespace airclay
