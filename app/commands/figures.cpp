// SPDX-License-Identifier: MIT
// `airclay figures`: draws the paper's figures from synthetic data.
#include <CLI/CLI.hpp>
#include <memory>

#include "app/cli/command.h"
#include "app/cli/output_paths.h"
#include "app/cli/progress.h"
#include "app/commands/paper_figures.h"
#include "engine/hull/carve.h"

namespace airclay {
namespace {

struct FigureOptions : CommonOptions {
  std::string out;
};

void runFigures(const FigureOptions& options) {
  checkVoxels(options.voxels);
  makeFolder(options.out);
  CommandGpu gpu(options);
  {
    Progress progress("drawing", figureSteps(), options.printsMessages());
    drawFigures(gpu, options.out, options.voxels, [&] { progress.advance(); });
  }
  printLine(options, "figure1.png to figure6.png in " + options.out);
}

}  // namespace

void addFigures(CLI::App& program, int&) {
  CLI::App* command =
      program.add_subcommand("figures", "draw figures 1 to 6 of the paper from synthetic data");
  const auto options = std::make_shared<FigureOptions>();
  command->add_option("--out", options->out, "output folder for figure1.png to figure6.png")
      ->type_name("DIR")
      ->required();
  addCommonOptions(*command, *options, Uses::kDeviceAndVoxels, false);
  command->callback([options] { runFigures(*options); });
}

}  // namespace airclay
