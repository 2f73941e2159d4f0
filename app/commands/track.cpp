// SPDX-License-Identifier: MIT
// `airclay track`: writes the hand poses of a recording.
#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "app/cli/output_paths.h"
#include "app/session/fit_options.h"
#include "app/session/take_options.h"
#include "app/session/take_tracking.h"
#include "app/session/tracking_summary.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

struct TrackOptions : CommonOptions {
  TakeInputOptions take;
  std::string poses, hand = "right";
  FitOptions fit;
};

void runTrack(const TrackOptions& options) {
  checkVoxels(options.voxels);
  checkWritable(options.poses);
  Take take = options.take.open();
  const HandModel hand = loadHand(options.hand);
  CommandGpu gpu(options);
  Tracking tracking;
  trackTake(gpu, take,
            {.hand = hand,
             .pipeline = options.fit.pipeline(options.voxels),
             .shows_progress = options.printsMessages()},
            [&](const PlayedFrame& frame) { tracking.add(frame, &take); });
  writePoses(options.poses, tracking.poses());
  if (options.json) printJson(tracking.json());
  for (const std::string& line : tracking.summary()) printLine(options, line);
  printLine(options, "poses in " + options.poses);
}

}  // namespace

void addTrack(CLI::App& program, int&) {
  CLI::App* command = program.add_subcommand("track", "track the hand in a recording and write its poses");
  const auto options = std::make_shared<TrackOptions>();
  addTakeOptions(*command, options->take);
  command
      ->add_option("--poses", options->poses,
                   "output file for the poses, one line per tracked frame: timestamp tx ty tz qx qy qz qw "
                   "(world_from_hand)")
      ->type_name("OUT.tum")
      ->required();
  addHandOption(*command, options->hand);
  addFitOptions(*command, options->fit);
  addCommonOptions(*command, *options, Uses::kDeviceAndVoxels, true);
  command->footer("Example:\n  airclay track TAKE --poses hand.tum --json");
  command->callback([options] { runTrack(*options); });
}

}  // namespace airclay
