// SPDX-License-Identifier: MIT
// `airclay offsets`: estimates the offsets between the cameras' clocks from a recording of a moving hand.
#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "app/cli/progress.h"
#include "app/session/take_options.h"
#include "capture/cameras/clock_offsets.h"
#include "capture/takes/player.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

// Ignore smaller silhouettes: a finger at the image's edge, or noise.
constexpr std::size_t kLeastPixels = 100;
// Ignore smaller offsets: a millimetre at 1 m/s.
constexpr double kSameClockS = 0.001;

struct OffsetsOptions : CommonOptions {
  TakeInputOptions take;
};

/// The centroid of a silhouette; nullopt if it is too small.
std::optional<Vec2> centroidOf(const Silhouette& mask) {
  Vec2 sum = Vec2::Zero();
  std::size_t count = 0;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (mask.contains(x, y)) {
        sum += Vec2(x, y);
        ++count;
      }
  if (count < kLeastPixels) return std::nullopt;
  return sum / static_cast<double>(count);
}

/// The motion that each camera saw, on its own clock.
std::vector<MotionSeries> motionIn(const OffsetsOptions& options, Take& take) {
  CommandGpu gpu(options);
  Pipeline pipeline(gpu, take.rig(), builtInHand(false),
                    {options.voxels, SilhouetteMethod::kPaper, FitMethod::kPaper});
  Player player(take, pipeline);
  std::vector<MotionSeries> series(take.rig().cameras.size());
  Progress progress("tracking the hand", take.frameCount(), options.printsMessages());
  for (int frame = 0; const std::optional<PlayedFrame> played = player.next(); ++frame) {
    progress.advance();
    if (played->background) continue;
    std::vector<double> times_s = take.cameraTimesOf(played->frame);
    if (times_s.empty()) times_s.assign(series.size(), take.timeOf(played->frame));
    const std::vector<Silhouette> masks = pipeline.gpuRig().unpack(pipeline.silhouettes().masks().host());
    for (std::size_t c = 0; c < series.size(); ++c) {
      if (take.missingCameras() >> c & 1) continue;
      const std::optional<Vec2> centroid = centroidOf(masks[c]);
      if (!centroid || (!series[c].times_s.empty() && times_s[c] <= series[c].times_s.back())) continue;
      series[c].times_s.push_back(times_s[c]);
      series[c].centroid_px.push_back(*centroid);
    }
  }
  return series;
}

void runOffsets(const OffsetsOptions& options) {
  checkVoxels(options.voxels);
  Take take = options.take.open();
  const ClockOffsets found = estimateClockOffsets(take.rig(), motionIn(options, take));
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
