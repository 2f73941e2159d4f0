// SPDX-License-Identifier: MIT
// One frame's masks, one per calibrated camera, to the visual hull's surface.
//
//     masks_to_hull TAKE FRAME HULL.obj
//
// TAKE holds rig.toml and silhouettes/NAME/000000.png … for each camera NAME. Instead of the GPU's carve(),
// carveReference(rig, masks, voxels) gives the same hull on the CPU.
#include <airclay/capture/takes/take.h>
#include <airclay/engine/core/error.h>
#include <airclay/engine/hull/hull_mesh.h>
#include <airclay/engine/mesh/mesh_file.h>

#include <cstdio>
#include <cstdlib>

using namespace airclay;

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: masks_to_hull TAKE FRAME HULL.obj\n");
    return 2;
  }
  try {
    Take take(argv[1]);
    const int frame = std::atoi(argv[2]);
    if (!take.hasSilhouettes() || frame < 0 || frame >= take.frameCount())
      throw Error(std::string(argv[1]) + ": no masks of frame " + argv[2]);
    Gpu gpu;
    const VoxelGrid grid = carve(gpu, take.rig(), silhouettesOf(take, frame), 128);
    const TriangleMesh hull = hullMesh(grid, take.rig().workspace);
    writeObj(argv[3], hull);
    std::printf("%zu triangles, %.1f cm3\n", hull.triangles.size(), 1e6 * massProperties(hull).volume_m3);
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
