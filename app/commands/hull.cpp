// SPDX-License-Identifier: MIT
// `airclay hull`: writes the visual hull of one frame as points.
#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "app/session/fit_options.h"
#include "app/session/take_options.h"
#include "capture/takes/player.h"
#include "engine/mesh/mesh_file.h"

namespace airclay {
namespace {

struct HullOptions : CommonOptions {
  TakeInputOptions take;
  int frame = 0;
  std::string out, silhouettes = "room";
};

std::vector<Eigen::Vector3f> occupiedCentres(const VoxelGrid& grid, const Workspace& workspace) {
  std::vector<Eigen::Vector3f> points;
  for (int z = 0; z < grid.voxels; ++z)
    for (int y = 0; y < grid.voxels; ++y)
      for (int x = 0; x < grid.voxels; ++x)
        if (grid.at(x, y, z)) points.push_back(voxelCenter(workspace, grid.voxels, x, y, z).cast<float>());
  return points;
}

void runHull(const HullOptions& options) {
  checkVoxels(options.voxels);
  Take take = options.take.open();
  CommandGpu gpu(options);
  // Pipeline needs a hand model, although no hand is tracked here.
  Pipeline pipeline(gpu, take.rig(), builtInHand(false),
                    {.voxels = options.voxels,
                     .silhouettes = silhouetteMethod(options.silhouettes),
                     .fit = FitMethod::kPaper});
  Player(take, pipeline).computeHull(options.frame);

  const std::vector<Eigen::Vector3f> points =
      occupiedCentres(pipeline.carver().download(), take.rig().workspace);
  const double voxel_m = pipeline.carver().voxelMetres();
  const double volume_m3 = static_cast<double>(points.size()) * std::pow(voxel_m, 3);
  writePly(options.out, points);
  if (options.json) printJson({{"occupied", points.size()}, {"voxel_m", voxel_m}, {"volume_m3", volume_m3}});
  printLine(options, std::to_string(points.size()) + " voxels of " + fixed(1000 * voxel_m, 2) + " mm, " +
                         fixed(1e6 * volume_m3, 1) + " cm3, in " + options.out);
}

}  // namespace

void addHull(CLI::App& program, int&) {
  CLI::App* command =
      program.add_subcommand("hull", "carve the visual hull of one frame and write it as points");
  const auto options = std::make_shared<HullOptions>();
  addTakeOptions(*command, options->take);
  addSilhouettesOption(*command, options->silhouettes);
  command->add_option("--frame", options->frame, "frame index, from 0, including the background frames")
      ->type_name("N")
      ->required();
  command
      ->add_option("--out", options->out, "output file for the centres of the occupied voxels, world, metres")
      ->type_name("FILE.ply")
      ->required();
  addCommonOptions(*command, *options, Uses::kDeviceAndVoxels, true);
  command->footer("Example:\n  airclay hull TAKE --frame 40 --voxels 256 --out hull.ply");
  command->callback([options] { runHull(*options); });
}

}  // namespace airclay
