// SPDX-License-Identifier: MIT
// `airclay offsets`: estimates the offsets between the cameras' clocks from a recording of a moving hand.
#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "app/session/clock_sync.h"
#include "app/session/take_options.h"
#include "engine/core/error.h"
#include "engine/hull/carve.h"

namespace airclay {
namespace {

// Ignore smaller offsets: a millimetre at 1 m/s.
constexpr double kSameClockS = 0.001;

struct OffsetsOptions : CommonOptions {
  TakeInputOptions take;
};

void runOffsets(const OffsetsOptions& options) {
  checkVoxels(options.voxels);
  Take take = options.take.open();
  CommandGpu gpu(options);
  const ClockOffsets found = offsetsFromMotion(gpu, take, options.voxels, options.printsMessages());
  nlohmann::ordered_json cameras = nlohmann::ordered_json::array();
  std::vector<std::vector<std::string>> rows = {{"camera", "offset", "standard error"}};
  std::string offsets;
  for (std::size_t c = 0; c < take.rig().cameras.size(); ++c) {
    const std::string& name = take.rig().cameras[c].name;
    const double offset_ms = 1000 * found.offset_s[c], deviation_ms = 1000 * found.deviation_s[c];
    cameras.push_back({{"name", name}, {"offset_ms", offset_ms}, {"deviation_ms", deviation_ms}});
    rows.push_back({name, fixed(offset_ms, 1) + " ms", fixed(deviation_ms, 1) + " ms"});
    if (std::abs(found.offset_s[c]) > kSameClockS) offsets += " --offset " + name + "=" + fixed(offset_ms, 1);
  }
  if (options.json) printJson({{"cameras", cameras}});
  if (options.printsMessages()) printTable(rows);
  printLine(options, offsets.empty() ? "the cameras' clocks agree" : "options:" + offsets);
}

}  // namespace

void addOffsets(CLI::App& program, int&) {
  CLI::App* command = program.add_subcommand(
      "offsets", "estimate the offsets between the cameras' clocks from a moving hand");
  const auto options = std::make_shared<OffsetsOptions>();
  addTakeOptions(*command, options->take);
  addCommonOptions(*command, *options, Uses::kDeviceAndVoxels, true);
  command->footer(
      "Record a hand that moves through the whole workspace for ten seconds, both fast and slowly. Pass the "
      "offsets to\nother commands as --offset.\n\nExamples:\n  airclay offsets TAKE\n  airclay sculpt TAKE "
      "--offset left=12.5");
  command->callback([options] { runOffsets(*options); });
}

}  // namespace airclay
