// SPDX-License-Identifier: MIT
// The options of hand tracking: --hand, --fit and --silhouettes.
#pragma once

#include <string>

#include "engine/pipeline.h"

namespace CLI {
class App;
}

namespace airclay {

void addHandOption(CLI::App& command, std::string& hand);

struct FitOptions {
  std::string fit = "robust", silhouettes = "room";

  PipelineOptions pipeline(int voxels) const;
};
void addFitOptions(CLI::App& command, FitOptions& options);
void addSilhouettesOption(CLI::App& command, std::string& silhouettes);
/// \pre the option was checked by addSilhouettesOption()
SilhouetteMethod silhouetteMethod(const std::string& silhouettes);

}  // namespace airclay
