// SPDX-License-Identifier: MIT
#include "app/session/fit_options.h"

#include <CLI/CLI.hpp>

namespace airclay {

void addHandOption(CLI::App& command, std::string& hand) {
  command
      .add_option("--hand", hand,
                  "hand model: right (default), left, or a skinned glTF binary with WebXR joint names")
      ->type_name("right|left|FILE.glb");
}

void addSilhouettesOption(CLI::App& command, std::string& silhouettes) {
  command
      .add_option("--silhouettes", silhouettes,
                  "segmentation: room (default), probabilities that tolerate people, shadows and changing "
                  "light; paper, the largest part that differs from the background")
      ->check(CLI::IsMember({"room", "paper"}).description(""))
      ->type_name("room|paper");
}

void addFitOptions(CLI::App& command, FitOptions& options) {
  command
      .add_option("--fit", options.fit,
                  "hand-fitting method: robust (default), the hand's outline in the images; paper, forces on "
                  "the voxel model, as published")
      ->check(CLI::IsMember({"robust", "paper"}).description(""))
      ->type_name("robust|paper");
  addSilhouettesOption(command, options.silhouettes);
}

SilhouetteMethod silhouetteMethod(const std::string& silhouettes) {
  return silhouettes == "paper" ? SilhouetteMethod::kPaper : SilhouetteMethod::kRoom;
}

PipelineOptions FitOptions::pipeline(int voxels) const {
  return {.voxels = voxels,
          .silhouettes = silhouetteMethod(silhouettes),
          .fit = fit == "paper" ? FitMethod::kPaper : FitMethod::kRobust};
}

}  // namespace airclay
