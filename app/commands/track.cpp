// SPDX-License-Identifier: MIT
// `airclay track`: writes the hand poses of a recording.
#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "app/cli/output_paths.h"
#include "app/session/clock_sync.h"
#include "app/session/fit_options.h"
#include "app/session/take_options.h"
#include "app/session/take_tracking.h"
#include "app/session/tracking_debug.h"
#include "app/session/tracking_summary.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

struct TrackOptions : CommonOptions {
  TakeInputOptions take;
  std::string poses, hand = "right", debug, sync = "off";
  FitOptions fit;
};

void runTrack(const TrackOptions& options) {
  checkVoxels(options.voxels);
  checkWritable(options.poses);
  Take take = options.take.open();
  const HandModel hand = loadHand(options.hand);
  CommandGpu gpu(options);
  if (options.sync == "auto") {
    const ClockOffsets clocks = offsetsFromMotion(gpu, take, options.voxels, options.printsMessages());
    TakeInputOptions corrected = options.take;
    for (std::size_t k = 1; k < clocks.offset_s.size(); ++k) {
      const std::string offset = take.rig().cameras[k].name + "=" + std::to_string(1000 * clocks.offset_s[k]);
      corrected.offsets.push_back(offset);
      printLine(options, "--offset " + offset);
    }
    take = corrected.open();
  }
  Tracking tracking;
  std::optional<TrackingDebug> debug;
  if (!options.debug.empty()) debug.emplace(options.debug, hand, take.rateHz());
  trackTake(gpu, take,
            {.hand = hand,
             .pipeline = options.fit.pipeline(options.voxels),
             .shows_progress = options.printsMessages()},
            [&](const Pipeline& pipeline, const PlayedFrame& frame) {
              tracking.add(frame, &take);
              if (debug) debug->add(pipeline, frame);
            });
  if (debug) debug->finish();
  writePoses(options.poses, tracking.poses());
  if (options.json) printJson(tracking.json());
  for (const std::string& line : tracking.summary()) printLine(options, line);
  printLine(options, "poses in " + options.poses);
  if (debug) printLine(options, "contact sheets and tracking.mp4 in " + options.debug);
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
  command
      ->add_option("--sync", options->sync,
                   "auto: estimate the offsets between the cameras' clocks from the moving hand and apply "
                   "them; off (default): trust the timestamps")
      ->check(CLI::IsMember({"auto", "off"}).description(""))
      ->type_name("auto|off");
  command
      ->add_option(
          "--debug", options->debug,
          "output folder for contact sheets, one per frame, and their video: each camera's image with "
          "the silhouette (yellow) and the fitted hand (green tracked, orange uncertain, red lost), "
          "next to the probability of the hand")
      ->type_name("DIR");
  addCommonOptions(*command, *options, Uses::kDeviceAndVoxels, true);
  command->footer("Example:\n  airclay track TAKE --poses hand.tum --json");
  command->callback([options] { runTrack(*options); });
}

}  // namespace airclay
