// SPDX-License-Identifier: MIT
// `airclay bench`: times each stage and compares it with its CPU reference and a peer.
#include "engine/validation/bench.h"

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "engine/hull/carve.h"

namespace airclay {
namespace {

std::string ratio(double value) {
  if (value <= 0) return "-";
  return fixed(value, value < 0.1 ? 3 : value < 1 ? 2 : 1);
}

struct BenchCommandOptions : CommonOptions {
  double stage_s = BenchOptions{}.stage_s;
};

void runBench(const BenchCommandOptions& options) {
  checkVoxels(options.voxels);
  CommandGpu gpu(options);
  const std::vector<StageTiming> stages = benchStages(gpu, {options.voxels, options.stage_s});
  std::vector<std::vector<std::string>> rows = {
      {"stage", "GPU ms", "wall ms", "work", "", "CPU reference", "peer", "peer library"}};
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const StageTiming& stage : stages) {
    rows.push_back({stage.name, fixed(stage.gpu_ms, 3), fixed(stage.wall_ms, 3), fixed(stage.work, 0),
                    stage.work_unit, ratio(stage.reference_ratio), ratio(stage.peer_ratio), stage.peer});
    list.push_back({{"name", stage.name},
                    {"device", stage.device},
                    {"gpu_ms", stage.gpu_ms},
                    {"wall_ms", stage.wall_ms},
                    {"work", stage.work},
                    {"work_unit", stage.work_unit},
                    {"reference_ratio", stage.reference_ratio},
                    {"peer", stage.peer},
                    {"peer_ratio", stage.peer_ratio}});
  }
  if (options.json) printJson({{"stages", list}});
  printLine(options, gpu.info().name + ", " + std::to_string(options.voxels) + " voxels per edge; medians");
  if (options.printsMessages()) printTable(rows);
}

}  // namespace

void addBench(CLI::App& program, int&) {
  CLI::App* command = program.add_subcommand("bench", "time each stage and the whole frame");
  const auto options = std::make_shared<BenchCommandOptions>();
  command->add_option("--seconds", options->stage_s, "time for repeated runs of each stage [1.2]")
      ->check(CLI::Range(0.0, 60.0).description(""))
      ->type_name("S");
  addCommonOptions(*command, *options, Uses::kDeviceAndVoxels, true);
  command->footer(
      "The columns \"CPU reference\" and \"peer\" are their times divided by Airclay's, measured in the same "
      "run. A peer is\nanother library that computes the same stage.");
  command->callback([options] { runBench(*options); });
}

}  // namespace airclay
